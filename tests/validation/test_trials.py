"""Sets of trials, their record, and the command."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pivotgait.cli import main
from pivotgait.exceptions import InputError, PlanFileError, UnknownNameError
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan, write_plan
from pivotgait.validation import (
    RecordError,
    RunOptions,
    RunSeries,
    TrialOptions,
    TrialResult,
    TrialSet,
    Verdict,
    judge,
    read_summary,
    run_trials,
    write_record,
)
from pivotgait.validation.metrics import measure
from pivotgait.validation.moved_scene import gait_of, scene_of
from pivotgait.validation.planned import planned_at
from pivotgait.validation.trials import stages_of

Call = Callable[..., tuple[int, str, str]]
NOMINAL = TrialOptions(perturbed=False)


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Call:
    def run(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main([str(each) for each in arguments])
        assert isinstance(caught.value.code, int)
        return caught.value.code, *capsys.readouterr()

    return run


@pytest.fixture(scope="module")
def trials(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> TrialSet:
    """A faithful run, a slip in the removal, a crash."""
    planned = planned_at(plan, faithful.time, faithful.fingers)
    good = TrialResult(
        seed=0,
        verdict=judge(plan, scene.robot, faithful, planned),
        metrics=measure(scene.robot, faithful, planned),
        series=faithful,
        planned=planned,
    )
    slip = replace(good, seed=1, verdict=Verdict(False, "slip", "03_removal", 3.2, "tip"))
    crash = TrialResult(2, Verdict(False, "crash", detail="code 11"))
    results = (good, slip, crash)
    return TrialSet(TrialOptions(), stages_of(plan, results), results)


def test_stages_count_every_trial(trials: TrialSet) -> None:
    data = trials.as_json()
    counts = [(stage["name"], stage["reached"], stage["passed"]) for stage in data["stages"]]
    assert counts == [
        ("00_lift", 2, 2),
        ("01_relocation", 2, 2),
        ("02_addition", 2, 2),
        ("03_removal", 2, 1),
        ("04_relocation", 1, 1),
        ("05_addition", 1, 1),
        ("final_hold", 1, 1),
    ]
    assert data["failures"] == {"slip": 1, "crash": 1}
    assert (data["trials"], data["passed"]) == (3, 1)
    assert data["rate"] == pytest.approx(1 / 3)
    assert data["wilson_95"][0] < data["rate"] < data["wilson_95"][1]
    assert [run["seed"] for run in data["runs"]] == [0, 1, 2]
    json.dumps(data, allow_nan=False)


def test_a_record_says_what_was_measured(
    trials: TrialSet, plan: GaitPlan, faithful: RunSeries, tmp_path: Path
) -> None:
    path, again = tmp_path / "record.h5", tmp_path / "again.h5"
    write_record(trials, plan, path)
    write_record(trials, plan, again)
    assert path.read_bytes() == again.read_bytes()
    assert read_summary(path, plan)["failures"] == {"slip": 1, "crash": 1}
    with h5py.File(path) as file:
        run = file["runs/0000"]
        np.testing.assert_array_equal(run["robot/q"], faithful.q)
        thumb = run["contacts/thumb"]
        np.testing.assert_allclose(thumb["normal_force"], thumb["planned_normal_force"], atol=1e-9)
        np.testing.assert_allclose(thumb["margin"], thumb["planned_margin"], atol=1e-9)
        assert set(file["runs"]) == {"0000", "0001", "0002"}
        assert not list(file["runs/0002"])


def test_a_record_of_another_plan_is_refused(
    trials: TrialSet, plan: GaitPlan, tmp_path: Path
) -> None:
    path = tmp_path / "record.h5"
    write_record(trials, plan, path)
    with pytest.raises(RecordError, match="another plan"):
        read_summary(path, replace(plan, seed=plan.seed + 1))


@pytest.mark.parametrize("data", [b"", b"no hdf5", None])
def test_damaged_records_are_refused(tmp_path: Path, data: bytes | None) -> None:
    path = tmp_path / "record.h5"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(RecordError):
        read_summary(path)


def test_robot_and_tool_must_be_the_scenes(plan: GaitPlan, scene: Scene) -> None:
    assert gait_of(plan, scene_of(plan)) == "default"
    text = plan.robot.urdf + "<!-- changed -->\n"
    with pytest.raises(PlanFileError, match="robot is not that of its scene"):
        scene_of(replace(plan, robot=replace(plan.robot, urdf=text)))
    text = plan.tool.urdf + "<!-- changed -->\n"
    with pytest.raises(PlanFileError, match="tool is not that of its scene"):
        scene_of(replace(plan, tool=replace(plan.tool, urdf=text)))
    with pytest.raises(InputError, match="no gait of its scene"):
        gait_of(replace(plan, phases=plan.phases[:2]), scene)


@pytest.mark.parametrize(
    ("options", "seeds", "error"),
    [
        (TrialOptions(run=RunOptions(controller="hybird")), [0], UnknownNameError),
        (TrialOptions(run=RunOptions(simulator="mujco")), [0], UnknownNameError),
        (TrialOptions(), [], InputError),
        (TrialOptions(), [-1], InputError),
    ],
)
def test_bad_trials_are_refused(
    plan: GaitPlan, options: TrialOptions, seeds: list[int], error: type[Exception]
) -> None:
    with pytest.raises(error):
        run_trials(plan, seeds, options)


def test_what_never_ends_is_a_timeout(plan: GaitPlan, name: str) -> None:
    options = replace(NOMINAL, run=RunOptions(simulator=name))
    found = run_trials(plan, [4], options, time_limit_s=0.2)
    assert found.as_json()["failures"] == {"timeout": 1}
    assert found.stages[0].reached == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--simulator", "bullet"], "unknown simulator 'bullet'"),
        (["--controller", "hybird"], "did you mean 'hybrid'"),
        (["--trials", "0"], "--trials"),
        (["-o", "/no such folder/record.h5"], "does not exist"),
    ],
)
def test_the_command_refuses_in_one_line(
    call: Call, plan: GaitPlan, tmp_path: Path, arguments: list[str], said: str
) -> None:
    path = tmp_path / "plan.h5"
    write_plan(plan, path)
    code, out, err = call("validate", path, *arguments)
    assert code == 2
    assert said in err
    assert out == ""
    assert len(err.strip().splitlines()) == 1


def test_the_command_tells_how_to_install_a_simulator(
    call: Call, plan: GaitPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    path = tmp_path / "plan.h5"
    write_plan(plan, path)
    code, out, err = call("validate", path, "--simulator", "mujoco")
    assert (code, out) == (2, "")
    said = "pivotgait: error: simulator: mujoco is not installed - pip install 'pivotgait[mujoco]'"
    assert err.strip().splitlines() == [said]


@pytest.mark.parametrize("kind", ["missing", "damaged", "without robot"])
def test_plans_that_cannot_be_tried(call: Call, plan: GaitPlan, tmp_path: Path, kind: str) -> None:
    path = tmp_path / "plan.h5"
    if kind == "damaged":
        path.write_bytes(b"no plan")
    elif kind == "without robot":
        phases = tuple(replace(each, robot=None) for each in plan.phases)
        write_plan(replace(plan, robot=None, phases=phases), path)
    code, out, err = call("validate", path)
    assert code == 2
    assert out == ""
    assert len(err.strip().splitlines()) == 1


@pytest.mark.slow
def test_the_command_tries_a_plan(call: Call, plan: GaitPlan, tmp_path: Path) -> None:
    path, record = tmp_path / "plan.h5", tmp_path / "record.h5"
    write_plan(plan, path)
    code, out, _ = call("validate", path, "--json", "-o", record)
    data: dict[str, Any] = json.loads(out)
    assert code == 0, data["runs"]
    assert data["passed"] == data["trials"] == 1
    assert {"simulator", "controller", "rate", "wilson_95", "stages", "failures"} <= data.keys()
    assert data["stages"][-1] == {"name": "final_hold", "reached": 1, "passed": 1}
    assert read_summary(record, plan)["passed"] == 1
