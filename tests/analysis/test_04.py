"""Laws of study 04: its problems can be solved, and what it counts as solved is."""

from __future__ import annotations

import json
from collections import Counter
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.plotting.planning_times import planning_times
from tests.analysis.studies import load_study


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return load_study("04")


@pytest.fixture(scope="module")
def scene() -> Any:
    return load_scene("knife")


@pytest.fixture(scope="module")
def relocations(study: ModuleType, scene: Any) -> Any:
    return study.Relocations(scene)


@pytest.fixture(scope="module")
def planned(relocations: Any) -> list[Any]:
    return relocations.planned(0)


@pytest.fixture(scope="module", params=["thumb + index", "with middle"])
def pinches(request, study, scene) -> list[Any]:
    rng = np.random.default_rng(11)
    return list(islice(study.Pinches(scene, study.GRASPS[request.param], rng), 4))


def test_the_posture_drawn_solves_its_problem(study, scene, pinches):
    for pinch in pinches:
        robot, key, q = pinch.world.robot, pinch.key, pinch.witness
        assert robot.within_limits(q)
        assert study.miss_of(pinch, q) < 1e-12
        held = pinch.world.holding(frozenset(key.contacts))
        distance, _ = held.clearance(q, key.rotation, key.position)
        assert distance > scene.clearance


def test_rods_end_at_the_contacts(pinches):
    for pinch in pinches:
        for rod, contact in zip(pinch.world.tool.shapes, pinch.key.contacts.values(), strict=True):
            radius, length = rod.size
            ends = [rod.translation + s * length / 2 * rod.rotation[:, 2] for s in (-1, 1)]
            assert np.allclose(ends[0], 0.0, atol=1e-12)
            assert np.allclose(ends[1] - radius * contact.normal, contact.point, atol=1e-12)
            gap = pinch.world.tip_gap(
                contact.finger, pinch.witness, pinch.key.rotation, pinch.key.position
            )
            assert gap < 1e-6


def test_pinched_things_are_as_thick_as_said(study, pinches):
    low, high = study.HELD_M
    for pinch in pinches:
        thumb, *others = (each.point for each in pinch.key.contacts.values())
        assert all(low <= np.linalg.norm(each - thumb) <= high for each in others)


def test_the_same_seeds_give_the_same_problems_and_searches(study, scene):
    def draw() -> Any:
        return next(iter(study.Pinches(scene, ("thumb", "index"), np.random.default_rng(7))))

    one, other = draw(), draw()
    assert np.array_equal(one.witness, other.witness)
    runs = [study.Search.run(each, 3) for each in (one, other)]
    assert runs[0].starts == runs[1].starts
    assert runs[0].failures == runs[1].failures


def test_a_contact_out_of_reach_is_counted_as_failed(study, scene, monkeypatch):
    pinch = next(iter(study.Pinches(scene, ("thumb", "index"), np.random.default_rng(7))))
    away = study.replace(pinch.key, position=pinch.key.position + np.array([3.0, 0.0, 0.0]))
    monkeypatch.setattr(study, "BUDGET", study.PostureOptions(starts=3, time_limit_s=np.inf))
    run = study.Search.run(study.replace(pinch, key=away), 0)
    assert not run.found
    assert np.isnan(run.miss_m)
    assert sum(run.failures.values()) == run.starts == 3
    assert all(reason.startswith("reach") for reason in run.failures)


def test_the_problems_of_a_plan_are_those_it_solved(study, scene, planned):
    plan = plan_gait(scene, seed=0)
    phases = {phase.name: phase for phase in plan.phases if phase.kind == "relocation"}
    assert [case.name for case in planned] == list(phases)
    for case in planned:
        q = phases[case.name].robot.q
        assert np.array_equal(case.problem.start, q[0])
        assert np.array_equal(case.problem.goal, q[-1])
        assert study.drift(case.problem, q) < 1e-8


def test_drift_is_the_distance_by_which_a_hold_is_left(study, planned):
    problem = planned[0].problem
    # The quill lifts hand and fingertips alike.
    lifted = np.array(problem.start)
    lifted[problem.robot.joint_names.index("J3")] += 1e-4
    found = study.drift(problem, np.stack((problem.start, lifted)))
    assert 1e-4 / np.sqrt(3.0) <= found <= 1e-4 * (1.0 + 1e-9)


def test_random_bends_move_only_the_finger_in_the_air(study, scene, relocations, planned):
    bent = relocations.scattered(planned, 5, 1)
    assert Counter(case.name for case in bent) == {planned[0].name: 5}
    fixed = np.ones(scene.robot.nv, dtype=bool)
    fixed[list(scene.robot.fingers["middle"].columns)] = False
    for case in bent:
        assert np.array_equal(case.problem.start[fixed], planned[0].problem.start[fixed])
        assert not np.array_equal(case.problem.start, planned[0].problem.start)
    # Bends that fold the finger behind the knife are part of the study: not every one is solved.
    runs = [study.Attempt.run(case.problem, 0) for case in bent]
    assert any(run.found for run in runs)
    assert all(run.drift_m < 1e-8 for run in runs if run.found)


@pytest.mark.parametrize(("solved", "count"), [(0, 10), (5, 10), (10, 10)])
def test_the_interval_holds_the_share(study, solved, count):
    found = study.share(solved, count)
    low, high = found["interval_95"]
    assert 0.0 <= low <= found["share"] <= high <= 1.0
    assert high - low < 0.6


def test_spreads_leave_out_what_is_not_there(study):
    assert study.spread([1.0, np.nan, 3.0])["median"] == 2.0
    assert np.isnan(study.spread([np.nan])["max"])


def test_unsolved_problems_keep_the_curve_below_the_top():
    times = np.array([0.1, np.inf, 0.3, 0.2])
    figure = planning_times({"one": {"some": times}}, limit_s=5.0)
    curve = figure.axes[0].lines[-1]
    assert curve.get_ydata()[-1] == 75.0
    assert np.all(np.diff(curve.get_ydata()) >= 0.0)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study_04")


@pytest.mark.slow
def test_a_quick_study_counts_everything_and_writes_its_files(study, out):
    result = study.main(quick=True, out=out)
    grasps = result["postures"]["grasps"]
    sets = result["relocations"]["sets"]
    summaries = [*grasps.values(), *(each for steps in sets.values() for each in steps.values())]
    for each in summaries:
        assert each["problems"] == len(each["runs"])
        assert each["solved"] <= sum(run["found"] for run in each["runs"])
    for each in grasps.values():
        assert each["solved"] >= 0.8 * each["problems"]
        tried = sum(run["starts"] for run in each["runs"])
        assert tried == each["solved"] + sum(each["starts_failed"].values())
        assert each["draws"]["kept"] == each["problems"]
        assert each["miss_m"]["max"] < 1e-9
    names = sorted(path.name for path in out.iterdir())
    assert names == ["success.json", "times.pdf", "times.png"]
    read = json.loads((out / "success.json").read_text())
    assert set(read["relocations"]["sets"]) == set(sets)
