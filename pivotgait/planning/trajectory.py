"""A timed motion of the arm-hand with the tool."""

from __future__ import annotations

from dataclasses import dataclass

from pivotgait.frozen import Array, FrozenArrays


@dataclass(frozen=True, eq=False)
class JointTrajectory(FrozenArrays):
    """N samples, at rest at both ends, in which the holding fingers keep their holds.

    Attributes:
        time: (N,) [s].
        q: (N, nv) joint positions [rad] or [m], on the constraint (9).
        v: (N, nv) joint velocities, with A v = b.
        a: (N, nv) joint accelerations, with A a = db/dt - dA/dt v.
        s: (N,) parameter of the tool's path.
        oRtool: (N, 3, 3) orientation of the tool, world <- tool.
        position: (N, 3) its centre of mass, world [m].
        linear_velocity: (N, 3) of the centre of mass [m/s].
        angular_velocity: (N, 3) [rad/s].
        linear_acceleration: (N, 3) of the centre of mass [m/s^2].
        angular_acceleration: (N, 3) [rad/s^2].
        speed_share: largest |v| / limit.
        acceleration_share: largest |a| / limit.
        drift: largest residual of eq. (9) on straight lines between samples [m].
    """

    time: Array
    q: Array
    v: Array
    a: Array
    s: Array
    oRtool: Array
    position: Array
    linear_velocity: Array
    angular_velocity: Array
    linear_acceleration: Array
    angular_acceleration: Array
    speed_share: float
    acceleration_share: float
    drift: float
