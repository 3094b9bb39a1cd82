"""Whether the tool's motion is a turn about a fixed pivot (Xue et al., eqs 1-2)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding, largest
from pivotgait.plans import GaitPlan, Phase
from pivotgait.plans.plan import PIVOT


def check_motion(plan: GaitPlan, phase: Phase) -> Iterator[Finding]:
    """Unit quaternions, eqs (1)-(2) at every sample on the pivot, no turning at both ends."""
    tool = phase.tool
    unit = np.abs(np.linalg.norm(tool.orientation, axis=1) - 1.0)
    yield largest("quaternion_norm", unit, phase)

    if phase.kind != "transfer":
        yield from _check_turning(plan, phase)
    omega = tool.angular_velocity
    speed = np.linalg.norm(omega, axis=1)
    end = int(speed[-1] > speed[0])
    time = float(phase.time[-1] if end else phase.time[0])
    yield Finding("rest_rad_s", float(max(speed[0], speed[-1])), phase.name, time_s=time)


def _check_turning(plan: GaitPlan, phase: Phase) -> Iterator[Finding]:
    """Eqs (1)-(2): where the tool is and moves follows from how it turns about the pivot."""
    tool = phase.tool
    # Each stored vector is compared with what orientation and angular quantities imply, never with
    # another stored one, so that a wrong dataset shows up in its own residual only.
    arm = tool.rotation.apply(-plan.tool.pivot_in_tool)
    omega = tool.angular_velocity
    velocity = np.cross(omega, arm)
    acceleration = np.cross(tool.angular_acceleration, arm) + np.cross(omega, velocity)
    stored = (
        ("position_m", tool.position, phase.contacts[PIVOT].point + arm),
        ("linear_velocity_m_s", tool.linear_velocity, velocity),
        ("linear_acceleration_m_s2", tool.linear_acceleration, acceleration),
    )
    for what, given, expected in stored:
        yield largest(what, np.linalg.norm(given - expected, axis=1), phase)


def check_pivot(plan: GaitPlan, phase: Phase, tip_radius: float) -> Iterator[Finding]:
    """The pivot stays where the first phase has it, on the table, whose normal is +z.

    The pivot is the centre of the tip's sphere, one radius above the table that the sphere touches.

    Args:
        plan: the plan.
        phase: one of its phases.
        tip_radius: radius of the tip's sphere [m], 0 if there is none.
    """
    pivot = phase.contacts[PIVOT]
    moved = float(np.linalg.norm(pivot.point - plan.phases[0].contacts[PIVOT].point))
    yield Finding("pivot_moved_m", moved, phase.name, PIVOT)
    gap = float(pivot.point[2]) - tip_radius - plan.table_height
    yield Finding("pivot_height_m", abs(gap), phase.name, PIVOT)
    tilt = float(np.linalg.norm(pivot.normal - np.array([0.0, 0.0, 1.0])))
    yield Finding("table_normal", tilt, phase.name, PIVOT)
