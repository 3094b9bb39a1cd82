"""A record gives back its run; a damaged one, or one of another plan, is refused in one line."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import (
    RecordError,
    RunSeries,
    TrialOptions,
    TrialResult,
    TrialSet,
    Verdict,
    write_record,
)
from pivotgait.validation.metrics import measure
from pivotgait.validation.planned import planned_at
from pivotgait.validation.record_reading import read_run
from pivotgait.validation.slips import fingertip_slips, tip_slip

RUN = "runs/0000"
FAILED = Verdict(False, "slip", "00_lift", 0.25, "tip slipped 3 mm")


def trial_set(result: TrialResult, *, perturbed: bool = False) -> TrialSet:
    return TrialSet(TrialOptions(perturbed=perturbed), (), (result,))


@pytest.fixture(scope="module")
def result(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> TrialResult:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    found = measure(scene.robot, faithful, planned)
    rows = faithful.every(5)
    at_rows = planned_at(plan, rows.time, rows.fingers)
    return TrialResult(0, Verdict(True), found, rows, at_rows)


@pytest.fixture(scope="module")
def record(plan: GaitPlan, result: TrialResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("record") / "record.h5"
    write_record(trial_set(result), plan, path)
    return path


def test_what_was_written_is_read(
    plan: GaitPlan, scene: Scene, result: TrialResult, record: Path
) -> None:
    run = read_run(record, plan)
    assert (run.simulator, run.controller) == ("pybullet", "hybrid")
    assert run.verdict == result.verdict
    assert run.metrics == result.metrics
    series, planned = result.series, result.planned
    assert run.motion.series.joint_names == series.joint_names
    for name in ("time", "q", "v", "tau", "tool_position", "force", "reading", "pivot_force"):
        np.testing.assert_array_equal(getattr(run.motion.series, name), getattr(series, name))
    np.testing.assert_allclose(run.motion.orientation_error, 0.0, atol=1e-7)
    np.testing.assert_array_equal(run.motion.tip_slip, tip_slip(series))
    for name, slip in fingertip_slips(scene.robot, series, planned).items():
        np.testing.assert_allclose(run.motion.fingertip_slips[name], slip, atol=1e-12)
    limit = np.where(scene.robot.effort_max > 0.0, scene.robot.effort_max, np.inf)
    np.testing.assert_allclose(run.motion.torque_share * limit, series.tau, atol=1e-12)


def test_a_failure_is_read_with_its_place(
    plan: GaitPlan, result: TrialResult, tmp_path: Path
) -> None:
    path = tmp_path / "record.h5"
    write_record(trial_set(replace(result, verdict=FAILED)), plan, path)
    assert read_run(path, plan).verdict == FAILED


def test_a_trial_that_never_ran_has_a_verdict_only(plan: GaitPlan, tmp_path: Path) -> None:
    path = tmp_path / "record.h5"
    verdict = Verdict(False, "crash", detail="the process ended with -11")
    write_record(trial_set(TrialResult(0, verdict)), plan, path)
    run = read_run(path, plan)
    assert run.verdict == verdict
    assert run.metrics is None
    assert run.motion is None


def test_a_run_that_ended_at_once_shows_nothing(
    plan: GaitPlan, result: TrialResult, tmp_path: Path
) -> None:
    early = result.series.time < 0.0
    names = ("time", "q", "v", "tau", "tool_position", "tool_orientation", "force", "reading")
    rows = {name: getattr(result.series, name)[early] for name in (*names, "pivot_force")}
    series = replace(result.series, **rows)
    planned = planned_at(plan, series.time, series.fingers)
    path = tmp_path / "record.h5"
    write_record(trial_set(replace(result, series=series, planned=planned)), plan, path)
    assert read_run(path, plan).motion is None


def test_perturbed_trials_are_no_run_of_the_plan(
    plan: GaitPlan, result: TrialResult, tmp_path: Path
) -> None:
    path = tmp_path / "trials.h5"
    write_record(trial_set(result, perturbed=True), plan, path)
    with pytest.raises(RecordError, match="perturbed"):
        read_run(path, plan)


def test_the_record_of_another_plan(plan: GaitPlan, record: Path) -> None:
    with pytest.raises(RecordError, match="another plan") as caught:
        read_run(record, replace(plan, seed=plan.seed + 1))
    assert caught.value.exit_code == 2


def without(name: str) -> Callable[[Any], None]:
    def damage(file: Any) -> None:
        del file[f"{RUN}/{name}"]

    return damage


def changed(name: str, change: Callable[[Any], Any]) -> Callable[[Any], None]:
    def damage(file: Any) -> None:
        values = change(file[f"{RUN}/{name}"][()])
        del file[f"{RUN}/{name}"]
        file[f"{RUN}/{name}"] = values

    return damage


def told(name: str, value: object) -> Callable[[Any], None]:
    def damage(file: Any) -> None:
        summary = json.loads(file.attrs["summary"])
        summary["runs"][0][name] = value
        file.attrs["summary"] = json.dumps(summary)

    return damage


def attribute(name: str, value: str) -> Callable[[Any], None]:
    def damage(file: Any) -> None:
        file[RUN].attrs[name] = value

    return damage


def holed(values: Any) -> Any:
    values[3] = np.nan
    return values


DAMAGES: dict[str, Callable[[Any], None]] = {
    "no joints": without("robot/q"),
    "no force": without("contacts/thumb/force"),
    "hole": changed("tool/position", holed),
    "short": changed("robot/tau", lambda values: values[:-1]),
    "flat": changed("robot/v", lambda values: values[:, 0]),
    "words": changed("robot/v", lambda values: np.full(values.shape, b"fast")),
    "backwards": changed("time", lambda values: values[::-1]),
    "no rotation": changed("tool/orientation", lambda values: 2.0 * values),
    "fingers": attribute("fingers", '["nose"]'),
    "no list": attribute("fingers", "3"),
    "joints": attribute("joint_names", "[]"),
    "no JSON": attribute("joint_names", "["),
    "verdict": told("passed", "yes"),
    "metrics": told("metrics", {"tip_slip_mm": 1.0}),
    "no words": told("failure", 3),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_damaged_records_are_refused(
    plan: GaitPlan, record: Path, tmp_path: Path, damage: Callable[[Any], None]
) -> None:
    path = tmp_path / "bad.h5"
    path.write_bytes(record.read_bytes())
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(RecordError, match=r"bad\.h5.*damaged") as caught:
        read_run(path, plan)
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_cut_records_are_refused(
    plan: GaitPlan, record: Path, tmp_path: Path, share: float
) -> None:
    path = tmp_path / "cut.h5"
    image = record.read_bytes()
    path.write_bytes(image[: int(share * len(image))])
    with pytest.raises(RecordError, match=r"cut\.h5"):
        read_run(path, plan)
