"""Torques that a run asked for, each as a share of its joint's limit."""

from __future__ import annotations

from typing import Any

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.joints import JointCurve, draw_joints
from pivotgait.plotting.run_axes import since_start
from pivotgait.plotting.style import styled
from pivotgait.validation.record_reading import RecordedMotion


@styled
def run_torques(plan: GaitPlan, motion: RecordedMotion) -> Any:
    """Every joint's torque or force over its limit in a run, as :func:`joint_torques` of a plan.

    Args:
        plan: that was carried out, with a robot.
        motion: the record of its run.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        InputError: if the plan has no robot.
        UrdfError: if the robot's URDF is broken.
    """
    time, shares = since_start(motion, motion.torque_share)
    names = motion.series.joint_names
    curves = {name: [JointCurve(time, s)] for name, s in zip(names, shares.T, strict=True)}
    return draw_joints(plan, curves, "torque /\nlimit [-]", end=float(motion.series.time[-1]))
