"""Whether the joints keep their limits and couplings, rest where phases meet, and do not jump."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding, largest, largest_joint
from pivotgait.certification.rigid_robot import RigidRobot
from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan, Phase, PlannedRobot, RobotMotion


def check_joints(
    planned: PlannedRobot, rigid: RigidRobot, phase: Phase, motion: RobotMotion
) -> Iterator[Finding]:
    """Limits of position, speed and torque by the URDF; couplings by the plan; rest at both ends.

    Args:
        planned: the robot of the plan.
        rigid: the robot of its URDF.
        phase: one of the plan's phases.
        motion: the robot's in that phase.
    """
    names, q = rigid.joint_names, motion.q
    beyond = np.maximum(np.maximum(rigid.lower - q, q - rigid.upper), 0.0)
    yield largest_joint("joint_position", beyond, phase, names)
    yield largest_joint("joint_speed", _share(motion.v, rigid.speed), phase, names)
    yield largest_joint("joint_torque", _share(motion.tau, rigid.effort), phase, names)
    ends = np.zeros_like(q)
    ends[[0, -1]] = np.abs(motion.v[[0, -1]])
    yield largest_joint("joint_rest", ends, phase, names)
    for one, other in planned.couplings:
        excess = np.maximum(q[:, names.index(one)] - q[:, names.index(other)], 0.0)
        found = largest("joint_coupling", excess, phase)
        yield Finding(found.what, found.value, found.phase, time_s=found.time_s, part=one)


def check_joint_seams(plan: GaitPlan, rigid: RigidRobot) -> Iterator[Finding]:
    """Jumps of the joints between each phase and its predecessor, at the later phase's start."""
    for before, after in zip(plan.phases[:-1], plan.phases[1:], strict=True):
        if before.robot is None or after.robot is None:
            continue
        jump = np.abs(after.robot.q[0] - before.robot.q[-1])
        worst = int(np.argmax(jump))
        part = rigid.joint_names[worst]
        yield Finding("seam_joint", float(jump[worst]), after.name, time_s=0.0, part=part)


def _share(values: Array, limit: Array) -> Array:
    """|values| / limit; nothing is allowed where the limit is 0."""
    size = np.abs(values)
    unlimited = np.where(size > 0.0, np.inf, 0.0)
    return np.divide(size, limit, out=unlimited, where=np.broadcast_to(limit > 0.0, size.shape))
