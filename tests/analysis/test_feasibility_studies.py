"""Studies 06 to 10: their quick runs, and the laws of the margins that 10 compares."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.validation.perturbation import Perturbation
from tests.analysis.studies import load_study


def quick(name: str, out: Path) -> dict[str, Any]:
    """What a quick run gives; its JSON file holds the same."""
    found: dict[str, Any] = load_study(name).main(quick=True, out=out)
    (file,) = out.glob("*.json")
    assert json.loads(file.read_text()).keys() == found.keys()
    assert list(out.glob("*.png"))
    assert list(out.glob("*.pdf"))
    return found


@pytest.mark.slow
def test_06_the_index_can_leave_in_more_places_if_the_knife_may_turn(tmp_path):
    found = quick("06", tmp_path)
    for rest, turn in zip(found["places_at_rest"], found["places_with_pivoting"], strict=True):
        assert 0.0 < rest["area"] < turn["area"] <= 1.0
        assert rest["evaluated"] < rest["grid"]


@pytest.mark.slow
def test_07_more_friction_needs_less_turning_and_plans_turn_no_less_than_needed(tmp_path):
    for tool in quick("07", tmp_path)["tools"]:
        least, planned = np.array(tool["least_deg"]), np.array(tool["planned_deg"])
        assert np.all(np.diff(least) <= 1e-2)
        assert np.all(planned >= least - 0.1)


@pytest.mark.slow
def test_08_who_may_leave_at_rest_needs_no_turn(tmp_path):
    for tool in quick("08", tmp_path)["tools"]:
        for found in tool["fingers"].values():
            room, turn = np.array(found["room_N"]), np.array(found["turn_deg"])
            assert np.array_equal(room >= 0.0, turn == 0.0)


@pytest.mark.slow
def test_09_a_larger_margin_is_paid_with_turning(tmp_path):
    for cells in quick("09", tmp_path)["tools"].values():
        known = [cell for cell in cells if np.isfinite(cell["margin"])]
        assert known
        for cell in known:
            assert cell["margin"] >= cell["reserve"] - 1e-6
        turns = [cell["reorientation_deg"] for cell in known]
        assert turns[-1] >= turns[0] - 0.1


@pytest.fixture(scope="module")
def trial_margins() -> ModuleType:
    return load_study("trial_margins")


@pytest.fixture(scope="module")
def trial_prediction() -> ModuleType:
    return load_study("trial_prediction")


@pytest.fixture(scope="module")
def margins(trial_margins: ModuleType) -> Any:
    scene = replace(load_scene("knife"), robot=None)
    return trial_margins.PlanMargins(plan_gait(scene, seed=0), scene)


ROBOT = load_scene("knife").robot
NONE = Perturbation.none(ROBOT)


def test_a_plan_as_assumed_keeps_its_reserve(margins):
    reserve = load_scene("knife").allocation.friction_reserve
    assert margins.margin(NONE) >= reserve - 1e-3
    # the planned forces are among those with the planned normal forces
    assert reserve - 1e-3 <= margins.margin(NONE, held=True) <= margins.margin(NONE) + 1e-3


def test_less_friction_leaves_a_margin_smaller_by_just_so_much(margins):
    whole = margins.margin(NONE)
    for scale in (0.7, 0.9, 1.2):
        draw = replace(NONE, finger_friction_scale=scale, table_friction_scale=scale)
        assert 1.0 - margins.margin(draw) == pytest.approx((1.0 - whole) / scale, abs=2e-3)


@pytest.mark.parametrize("name", ["offset_x", "offset_y", "offset_yaw", "handle_growth"])
def test_an_error_of_place_moves_fingers_along_the_surface_alone(trial_margins, margins, name):
    draw = trial_margins.alone(ROBOT, name, 1.0)
    for each in margins.moments:
        there = trial_margins.perturbed(each.grasps, draw).problem
        moved = there.lever - each.grasps.problem.lever
        assert np.array_equal(moved[:, 0], np.zeros_like(moved[:, 0])), "the pivot stays"
        outwards = -np.sum(moved * there.normals, axis=2)[:, 1:]
        assert np.allclose(outwards, 0.5 * draw.handle_growth, atol=1e-12)
    size = np.linalg.norm(moved, axis=2).max()
    assert 1e-4 < size < 6e-3


def test_wrong_sensors_change_the_held_margin_alone(margins):
    gain = {name: 1.25 if name == "thumb" else 0.75 for name in NONE.sensing.gain}
    draw = replace(NONE, sensing=replace(NONE.sensing, gain=gain))
    assert margins.margin(draw) == margins.margin(NONE)
    assert margins.margin(draw, held=True) < margins.margin(NONE, held=True)


def test_a_plan_as_assumed_misses_no_reading(margins):
    assert margins.sensed_margin(NONE) == 0.0


@pytest.mark.parametrize("error", [0.3, 0.6, 0.9])
def test_readings_that_are_too_large_must_be_missed_the_more(margins, error):
    """Two fingers that oppose each other cannot press unequally: what one reads too much, and the
    other too little, friction has to bear or the readings miss."""
    missed = []
    for share in (error - 0.1, error):
        gain = {name: 1.0 + share * (1.0 if name == "thumb" else -1.0) for name in ROBOT.fingers}
        draw = replace(NONE, sensing=replace(NONE.sensing, gain=gain))
        missed.append(-margins.sensed_margin(draw))
    assert 0.0 < missed[0] < missed[1]
    # the planned forces miss by no more than the error of the largest of them
    most = max(float(each.normal.max()) for each in margins.moments)
    assert missed[1] <= error * most + 1e-2


def test_a_sensor_that_reads_nothing_misses_all_that_is_wanted(margins):
    gain = dict.fromkeys(ROBOT.fingers, 0.0)
    draw = replace(NONE, sensing=replace(NONE.sensing, gain=gain))
    most = max(float(each.normal[:, 1:].max()) for each in margins.moments)
    assert -margins.sensed_margin(draw) == pytest.approx(most, abs=2e-2)


@pytest.mark.parametrize("seed", range(4))
def test_chance_is_the_share_of_shuffles(trial_prediction, seed):
    rng = np.random.default_rng(seed)
    failed = (rng.uniform(size=30) < 0.4).astype(float)
    score = np.round(rng.normal(size=30) - 0.5 * failed, 1)
    area = trial_prediction.roc(score, failed)[2]
    areas = [trial_prediction.roc(score, rng.permutation(failed))[2] for _ in range(2000)]
    found = trial_prediction.chance(score, failed, rng)
    assert found == pytest.approx(np.mean(np.array(areas) >= area - 1e-9), abs=0.04)


def test_scores_that_tell_all_are_no_chance(trial_prediction):
    failed = np.repeat([1.0, 0.0], 20)
    rng = np.random.default_rng(0)
    assert trial_prediction.chance(-failed, failed, rng) == pytest.approx(1e-4, rel=1e-3)
    assert trial_prediction.chance(failed, failed, rng) == 1.0
    assert np.isnan(trial_prediction.chance(failed, np.zeros(40), rng))


@pytest.mark.parametrize("seed", range(4))
def test_the_area_is_the_chance_of_telling_two_trials_apart(trial_prediction, seed):
    rng = np.random.default_rng(seed)
    failed = np.round(rng.uniform(size=40))
    score = np.round(rng.normal(size=40) - 0.7 * failed, 1)  # with ties
    false, true, area = trial_prediction.roc(score, failed)
    apart = score[failed == 0.0][:, None] - score[failed == 1.0]
    assert area == pytest.approx(np.mean((apart > 0.0) + 0.5 * (apart == 0.0)))
    assert area == pytest.approx(np.trapezoid(true, false))
    low, high = trial_prediction.roc_interval(score, failed, rng, draws=200)
    assert low < area < high


def test_one_outcome_has_no_area(trial_prediction):
    assert np.isnan(trial_prediction.roc(np.arange(3.0), np.zeros(3))[2])


def test_a_line_cut_short_by_a_kill_is_done_again(tmp_path):
    study, file = load_study("10"), tmp_path / "trials.jsonl"
    file.write_text('{"seed": 3, "passed": true}\n{"seed": 4, "pas')
    assert study.read_kept(file) == {3: {"seed": 3, "passed": True}}
    assert study.read_kept(tmp_path / "none") == {}


@pytest.mark.slow
def test_10_two_trials_are_kept_and_not_done_again(tmp_path, monkeypatch):
    study = load_study("10")
    found = study.main(quick=True, out=tmp_path, workers=1)
    assert [each["seed"] for each in found["rows"]] == [0, 1]
    for each in found["rows"]:
        assert 1.0 <= each["errors_size"] <= found["enlarged"] == 2.5
        assert -60.0 <= each["sensed_margin_N"] <= 0.0
    monkeypatch.setattr(study, "run_trials", None)
    assert study.main(quick=True, out=tmp_path)["rows"] == found["rows"]
