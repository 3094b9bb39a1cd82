"""Verdicts on whole gaits: what binds is named, and what is said to mend it does."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.feasibility import Variants, Verdict, VerdictOptions, judge, rehearse
from pivotgait.gaits.steps import plan_steps
from pivotgait.margins import phase_margins
from pivotgait.models import RelocationPhase, load_scene
from pivotgait.phases.grasp import Setting

VARIANTS = Variants(load_scene("knife"))


@dataclass(frozen=True)
class Case:
    """A knife that cannot do its gait, and what must be found to bind."""

    changes: dict[str, float] = field(default_factory=dict)
    turn_max_deg: float | None = None
    phase: str = "00_lift"
    kinds: tuple[str, ...] = ("friction", "normal_max")


CASES = {
    "slippery handle": Case({"contacts.*.friction": 0.25}),
    "heavy knife": Case({"tool.mass_scale": 4.0}),
    "weak fingers": Case({"contacts.*.normal_force_N.max": 1.2}),
    "contact on the far side": Case(
        {"contacts.middle_flat.around_deg": -90.0}, phase="03_removal", kinds=("normal_min",)
    ),
    "no pivoting": Case(turn_max_deg=0.0, phase="03_removal", kinds=("turn",)),
    "rolled lift": Case({"tool.roll_deg": 60.0}, phase="03_removal"),
    "hard to press": Case({"table.normal_force_N.min": 1.5}, kinds=("normal_min",)),
    "hasty lift": Case({"lift.duration_s": 0.15}),
    "hasty addition": Case(
        {"addition.duration_s": 0.05}, phase="02_addition", kinds=("force_rate",)
    ),
}


SLOW = (
    "contact on the far side",
    "rolled lift",
    "hasty lift",
    "hasty addition",
    "slippery handle",
    "heavy knife",
    "weak fingers",
)


@lru_cache
def judged(name: str) -> Verdict:
    case = CASES[name]
    options = VerdictOptions(volume=False, turn_max_deg=case.turn_max_deg)
    return judge(VARIANTS, options, changes=case.changes)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in CASES],
)
def test_the_named_mend_makes_it_feasible(name):
    case, found = CASES[name], judged(name)
    assert not found.feasible
    assert found.binding.phase == case.phase
    assert found.binding.kind in case.kinds
    assert found.mends
    for mend in found.mends:
        changes = {path: v for path, v in case.changes.items() if path != mend.change}
        turn = case.turn_max_deg
        if mend.change == "turn_max_deg":
            turn = mend.to
        else:
            changes[mend.change] = mend.to
        scene = VARIANTS.scene_with(changes)
        assert rehearse(scene, scene.gaits["default"], turn_max_deg=turn).obstacle is None, mend
        now = case.changes.get(mend.change)
        assert now is None or mend.from_ == now


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slippery handle", "heavy knife", "weak fingers"])
def test_much_less_than_the_mend_does_not_do(name):
    case, found = CASES[name], judged(name)
    straight = [m for m in found.mends if not m.change.endswith(("_deg", "along_m"))]
    assert straight
    for mend in straight:
        less = mend.from_ + 0.97 * (mend.to - mend.from_)
        changes = {path: v for path, v in case.changes.items() if path != mend.change}
        scene = VARIANTS.scene_with({**changes, mend.change: less})
        assert rehearse(scene, scene.gaits["default"]).obstacle is not None


@pytest.mark.parametrize(
    "name", ["knife", "wrench", pytest.param("screwdriver", marks=pytest.mark.slow)]
)
def test_every_builtin_gait_is_feasible_and_says_how_far(name):
    found = judge(Variants(load_scene(name)))
    assert found.feasible
    assert not found.mends
    margins = found.margins
    assert margins.friction is not None
    assert margins.friction.value >= 0.25 - 1e-6  # the scenes' reserve
    assert margins.robust["friction_drop"].value == pytest.approx(0.25, abs=2e-3) or (
        margins.robust["friction_drop"].value > 0.25
    )
    ball, _ = margins.ball
    assert 0.99 * ball.radius_N <= ball.at_least_N <= ball.radius_N
    assert found.binding.kind in ("friction", "lift_off")
    assert margins.volume.volume_N6 > 0.0


def test_the_rehearsal_agrees_with_the_planner():
    scene = load_scene("knife")
    configs = [c for c in scene.gaits["default"] if not isinstance(c, RelocationPhase)]
    planned = plan_steps(Setting.of(scene), configs)
    found = rehearse(scene, configs)
    for step, phase in zip(planned, found.phases, strict=True):
        assert phase.name == step.name
        assert phase.reorientation_deg == pytest.approx(step.phase.reorientation_deg, abs=0.05)
        for margins in phase_margins(phase).contacts.values():
            assert np.nanmin(margins.friction) > 0.0
    assert found.phases[2].record["solver"] == "turn"


def _numbers(data: Any) -> list[float]:
    if isinstance(data, dict):
        return [n for each in data.values() for n in _numbers(each)]
    if isinstance(data, list):
        return [n for each in data for n in _numbers(each)]
    return [data] if isinstance(data, float) else []


@pytest.mark.parametrize("name", ["", "heavy knife", "no pivoting"])
def test_json_is_complete_and_finite(name):
    found = judged(name) if name else judge(VARIANTS)
    data = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert data.keys() == {"feasible", "binding", "mends", "margins"}
    assert data["binding"].keys() >= {"kind", "contact", "phase", "time_s"}
    assert all(mend.keys() >= {"change", "from", "to"} for mend in data["mends"])
    assert data["margins"].keys() >= {"friction", "lift_off", "torque", "robust", "wrench_ball"}
    assert len(_numbers(data)) > 10
    assert all(math.isfinite(number) for number in _numbers(data))


def test_bad_questions_are_refused():
    with pytest.raises(UnknownNameError, match="gait"):
        judge(VARIANTS, VerdictOptions(gait="dance"))
    for angle in (-1.0, 200.0, float("nan")):
        with pytest.raises(InputError, match="deg"):
            judge(VARIANTS, VerdictOptions(turn_max_deg=angle))
