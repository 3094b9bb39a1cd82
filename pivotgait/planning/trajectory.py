"""A timed motion of the arm-hand with the tool."""

from __future__ import annotations

from dataclasses import dataclass

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plans import ToolMotion


@dataclass(frozen=True, eq=False)
class JointTrajectory(FrozenArrays):
    """N samples, at rest at both ends, in which the holding fingers keep their holds.

    Attributes:
        time: (N,) [s].
        q: (N, nv) joint positions [rad] or [m], on the constraint (9).
        v: (N, nv) joint velocities, with A v = b.
        a: (N, nv) joint accelerations, with A a = db/dt - dA/dt v.
        s: (N,) parameter of the tool's path.
        tool: N samples of the tool's motion.
        speed_share: largest |v| / limit.
        acceleration_share: largest |a| / limit.
        drift: largest residual of eq. (9) on straight lines between samples [m].
    """

    time: Array
    q: Array
    v: Array
    a: Array
    s: Array
    tool: ToolMotion
    speed_share: float
    acceleration_share: float
    drift: float
