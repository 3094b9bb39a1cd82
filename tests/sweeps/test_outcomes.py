"""What cells compute, against the package's own planners."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import pivot_motion
from pivotgait.exceptions import InfeasibleError
from pivotgait.forces import allocate
from pivotgait.gaits.steps import plan_steps
from pivotgait.models import LiftPhase, RelocationPhase, Scene
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Setting
from pivotgait.sweeps import Study, parse_study
from pivotgait.sweeps.evaluator import COLUMNS, Evaluator
from pivotgait.sweeps.outcome import Outcome
from pivotgait.sweeps.scene_family import SceneFamily

REMOVALS = """\
schema: pivotgait-study/1
name: removals
scene: knife
compute: removal
axes:
  contacts.*.friction: {values: [0.1, 0.8]}
  contacts.middle_flat.along_m: {values: [0.062, 9.0]}
"""


def holds(scene: Scene) -> bool:
    """Whether the lift's fingers hold the tool at its end, by one conic program."""
    lift = scene.gaits["default"][0]
    assert isinstance(lift, LiftPhase)
    rotation = Rotation.from_quat(scene.lift_rotation(lift.to).as_quat()[None])
    setting = Setting.of(scene)
    motion = pivot_motion(setting.body, rotation, np.zeros((1, 3)), np.zeros((1, 3)))
    fingers = [scene.contacts[name] for name in lift.contacts]
    return bool(allocate(allocation_problem(setting, motion, fingers), "clarabel").feasible[0])


def test_static_cells_agree_with_conic_programs(grid: Study, drawn: Study) -> None:
    seen = set()
    for study in (grid, drawn):
        family = SceneFamily(study.config, study.scene, None)
        found = Evaluator(study).outcomes(range(study.cells.count))
        for number, outcome in enumerate(found):
            assert (outcome.status, outcome.reason) == ("done", "")
            wanted = holds(family.scene(study.cells.cell(number).values))
            assert outcome.results["feasible"] is wanted
            depth = outcome.results["depth_N"]
            assert isinstance(depth, float)
            assert (depth >= -1e-9) is wanted
            seen.add(wanted)
    assert seen == {True, False}


def test_cells_alone_and_together_agree(grid: Study) -> None:
    work = Evaluator(grid)
    together = work.outcomes(range(30))
    for number in (0, 7, 29):
        (alone,) = work.outcomes([number])
        assert alone.results["feasible"] == together[number].results["feasible"]
        assert alone.results["depth_N"] == pytest.approx(
            together[number].results["depth_N"], rel=1e-6, abs=1e-9
        )


@pytest.mark.parametrize(
    ("axis", "reason"),
    [
        ("tool.pitch_deg: {values: [1]}", "over the table"),
        ("table.friction: {values: [-0.5]}", "table.friction: must be greater than 0"),
        ("contacts.index_edge.along_m: {values: [9]}", "contacts.index_edge"),
        ("lift.steps: {values: [10.5]}", "whole number"),
        ("tool.mass_scale: {values: [-1]}", "tool.mass_scale"),
        ("lift.contacts.0: {names: [thumb]}", "did you mean 'thumb_spine'"),
    ],
)
def test_values_that_make_no_scene_are_a_result(axis: str, reason: str) -> None:
    text = f"schema: pivotgait-study/1\nname: no\nscene: knife\ncompute: static\naxes:\n  {axis}\n"
    (outcome,) = Evaluator(parse_study(text)).outcomes([0])
    assert outcome.status == "invalid"
    assert reason in outcome.reason
    assert dict(outcome.results) == {}


def test_grasps_of_different_fingers_in_one_batch() -> None:
    text = """\
schema: pivotgait-study/1
name: fingers
scene: knife
compute: static
axes:
  lift.contacts.1: {names: [index_edge, middle_flat, index_edge_near]}
  contacts.*.friction: {values: [0.3, 1.0]}
"""
    study = parse_study(text)
    family = SceneFamily(study.config, study.scene, None)
    for number, outcome in enumerate(Evaluator(study).outcomes(range(6))):
        wanted = holds(family.scene(study.cells.cell(number).values))
        assert outcome.results["feasible"] is wanted


def test_removals_are_those_of_the_planner() -> None:
    study = parse_study(REMOVALS)
    weak, off, good, off_too = Evaluator(study).outcomes(range(4))
    assert (weak.status, weak.results) == ("done", {"feasible": False})
    assert "00_lift" in weak.reason
    assert off.status == off_too.status == "invalid"
    scene = SceneFamily(study.config, study.scene, None).scene(study.cells.cell(2).values)
    gait = [each for each in scene.gaits["default"] if not isinstance(each, RelocationPhase)]
    phase = plan_steps(Setting.of(scene), gait)[-1].phase
    assert phase is not None
    assert phase.kind == "removal"
    assert good.results["reorientation_deg"] == phase.reorientation_deg
    assert good.results.keys() == COLUMNS["removal"].keys()
    first = SceneFamily(study.config, study.scene, None).scene(study.cells.cell(0).values)
    with pytest.raises(InfeasibleError):
        plan_steps(Setting.of(first), gait)


def test_a_defect_is_told(grid: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> Scene:
        raise ZeroDivisionError("what now")

    monkeypatch.setattr(SceneFamily, "scene", broken)
    (outcome,) = Evaluator(grid).outcomes([0])
    assert outcome == Outcome("error", "ZeroDivisionError: what now")


@pytest.mark.slow
def test_plans_and_trials_of_the_knife() -> None:
    text = """\
schema: pivotgait-study/1
name: trials
scene: knife
compute: trials
trials: {count: 1, perturbed: false}
axes:
  table.friction: {values: [0.4]}
draws: 2
"""
    found = Evaluator(parse_study(text)).outcomes([0, 1])
    for outcome in found:
        assert outcome.status == "done"
        assert outcome.results.keys() == COLUMNS["trials"].keys()
        assert outcome.results["valid"] is True
        assert outcome.results["trials"] == 1
    (plan,) = Evaluator(
        parse_study(
            text.replace("trials: {count: 1, perturbed: false}\n", "")
            .replace("draws: 2\n", "")
            .replace("compute: trials", "compute: plan")
        )
    ).outcomes([0])
    assert plan.results.items() <= found[0].results.items()
