"""Whether a tool that leaves the table moves as it says, and rests on nothing but the fingers.

Positions, velocities and accelerations of its mass centre must tell one story by the trapezoid
rule, with the allowances of :mod:`pivotgait.certification.sampling`. As long as the table pushes
on the tip, the tip is at the pivot.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding, largest
from pivotgait.certification.limits import LIMITS
from pivotgait.frozen import Array
from pivotgait.plans import PIVOT, GaitPlan, Phase

_FREE_N = LIMITS["free_force_n"].bound
_ROUNDING = 1.0 + 1e-6


def check_transfer(plan: GaitPlan, phase: Phase, tip_radius: float) -> Iterator[Finding]:
    """Findings on the tool's way off the table.

    Args:
        plan: the plan.
        phase: one of its transfers.
        tip_radius: radius of the tip's sphere [m].
    """
    tool = phase.tool
    step = np.diff(phase.time)[:, None]
    surge, speed = tool.linear_acceleration, tool.linear_velocity
    jump = _with_neighbours(np.linalg.norm(np.diff(surge, axis=0), axis=1))
    way = np.diff(tool.position, axis=0) - 0.5 * step * (speed[:-1] + speed[1:])
    change = np.diff(speed, axis=0) - 0.5 * step * (surge[:-1] + surge[1:])
    yield largest("rise_excess_m", _beyond(way, step[:, 0] ** 2 * jump / 8.0), phase)
    yield largest("rise_rate_excess_m_s", _beyond(change, 0.5 * step[:, 0] * jump), phase)
    ends = np.linalg.norm(speed[[0, -1]], axis=1)
    end = int(np.argmax(ends))
    yield Finding("rest_m_s", float(ends[end]), phase.name, time_s=float(phase.time[-end]))

    pivot = phase.contacts[PIVOT]
    tip = tool.position + tool.rotation.as_matrix() @ plan.tool.pivot_in_tool
    away = np.linalg.norm(tip - pivot.point, axis=1)
    bears = np.linalg.norm(pivot.force, axis=1) > _FREE_N
    yield largest("borne_tip_m", np.where(bears, away, 0.0), phase, PIVOT)
    depth = plan.table_height + tip_radius - tip[:, 2]
    yield largest("tip_depth_m", np.maximum(depth, 0.0), phase, PIVOT)


def _beyond(error: Array, allowed: Array) -> Array:
    excess = np.linalg.norm(error, axis=1) - allowed * _ROUNDING
    return np.asarray(np.maximum(excess, 0.0))


def _with_neighbours(values: Array) -> Array:
    padded = np.pad(values, 1, mode="edge")
    return np.maximum(np.maximum(padded[:-2], padded[2:]), values)
