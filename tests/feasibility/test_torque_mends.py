"""Joints that are too weak: who binds is named, and the strength that mends it suffices."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from pivotgait.certification import certify
from pivotgait.exceptions import InfeasibleError, SceneError
from pivotgait.feasibility import Variants, Verdict, VerdictOptions, judge
from pivotgait.gaits import plan_gait
from pivotgait.margins import largest_share
from pivotgait.models import export_scene, load_scene, parse_scene
from pivotgait.models.parameters import EFFORT_SCALE

TEXT = export_scene("knife")
LIFT = Variants(parse_scene(TEXT[: TEXT.index("    - {kind: relocation")]))
WEAK = 0.1
OPTIONS = VerdictOptions(hand=True, volume=False)


@lru_cache
def judged(scale: float) -> Verdict:
    return judge(LIFT, OPTIONS, changes={EFFORT_SCALE: scale})


def test_efforts_scale_in_robot_and_text_alike():
    scene, other = LIFT.scene, LIFT.scene_with({EFFORT_SCALE: 0.5, "table.friction": 0.3})
    np.testing.assert_allclose(other.robot.effort_max, 0.5 * scene.robot.effort_max)
    assert other.table.friction == 0.3
    # a plan carries the text, and the certificate reads it
    plan = plan_gait(other)
    assert certify(plan).valid
    used = largest_share(plan, "torque").value
    assert used == pytest.approx(2.0 * largest_share(plan_gait(scene), "torque").value, rel=1e-6)


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf"), "strong"])
def test_scales_that_are_none_are_refused(scale):
    with pytest.raises(SceneError, match=EFFORT_SCALE):
        LIFT.scene_with({EFFORT_SCALE: scale})


def test_a_scene_without_a_robot_has_no_efforts():
    lines = TEXT.splitlines(keepends=True)
    start = next(k for k, line in enumerate(lines) if line.startswith("robot:"))
    end = next(k for k, line in enumerate(lines) if line.startswith("contacts:"))
    bare = parse_scene("".join(lines[:start] + lines[end:]).split("    - {kind: relocation")[0])
    with pytest.raises(SceneError, match="no robot"):
        Variants(bare).scene_with({EFFORT_SCALE: 2.0})


def test_the_joint_that_binds_is_named():
    found = judged(WEAK)
    assert not found.feasible
    assert found.binding.kind == "torque"
    assert found.binding.contact in LIFT.scene.robot.joint_names
    assert found.binding.phase == "00_lift"
    assert f"torque of {found.binding.contact}" in found.binding.text


def test_the_named_strength_suffices_and_much_less_does_not():
    (mend,) = judged(WEAK).mends
    assert mend.change == EFFORT_SCALE
    assert mend.from_ == WEAK < mend.to
    assert mend.size == pytest.approx((mend.to - WEAK) / WEAK)
    assert judged(mend.to).feasible
    with pytest.raises(InfeasibleError, match="torque"):
        plan_gait(LIFT.scene_with({EFFORT_SCALE: WEAK + 0.9 * (mend.to - WEAK)}))


def test_joints_weak_beyond_reach_have_no_mend():
    found = judge(LIFT, OPTIONS, changes={EFFORT_SCALE: 1e-3})
    assert not found.feasible
    assert found.binding.kind == "torque"
    assert not found.mends


def test_no_mends_are_sought_unless_asked_for():
    options = VerdictOptions(hand=True, volume=False, mends=0)
    assert not judge(LIFT, options, changes={EFFORT_SCALE: WEAK}).mends


@pytest.mark.slow
def test_a_whole_gait_is_mended():
    variants = Variants(load_scene("knife"))
    found = judge(variants, OPTIONS, changes={EFFORT_SCALE: WEAK})
    (mend,) = found.mends
    assert certify(plan_gait(variants.scene_with({EFFORT_SCALE: mend.to}))).valid
