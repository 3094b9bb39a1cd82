"""Timing of a smooth path under joint speed and acceleration limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pivotgait.frozen import Array
from pivotgait.kinematics import project, resolve
from pivotgait.planning.manifold import TOLERANCE, Manifold
from pivotgait.planning.smoothing import SmoothPath
from pivotgait.planning.trajectory import JointTrajectory

GRID = 400
"""Moments at which a motion of unit length is looked at for its limits."""
SAMPLE_TOLERANCE = 1e-9
"""Of eq. (9) at samples [m]."""
ROUNDS = 4
"""Of slowing down, when corrections on the manifold have raised speeds."""


def time_law(tau: Array) -> tuple[Array, Array, Array]:
    """u, du/dtau and d2u/dtau2 of the quintic from rest to rest; tau in [0, 1]."""
    u = tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2)
    rate = 30.0 * tau**2 * (1.0 - tau) ** 2
    change = 60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau)
    return u, rate, change


def least_duration(path: SmoothPath, speed_max: Array, acceleration_max: Array) -> float:
    """Shortest time [s] of a path under the quintic law.

    Speeds fall with the inverse of the duration, accelerations with its square.

    Args:
        path: to be timed.
        speed_max: (nv,) [rad/s] or [m/s].
        acceleration_max: (nv,) [rad/s^2] or [m/s^2].
    """
    u, rate, change = time_law(np.linspace(0.0, 1.0, GRID))
    first, second = path(u, 1)[0], path(u, 2)[0]
    speed = np.abs(first * rate[:, None]) / speed_max
    acceleration = np.abs(second * rate[:, None] ** 2 + first * change[:, None])
    return float(max(speed.max(), np.sqrt((acceleration / acceleration_max).max()), 1e-3))


def time_path(
    manifold: Manifold, path: SmoothPath, sample_s: float, shares: tuple[float, float]
) -> JointTrajectory | None:
    """Sample a path so that speeds and accelerations stay below shares of the robot's limits.

    Every sample is projected on eq. (9); v and a are the nearest to the curve's own that lie on
    its tangent: A v = b and A a = db/dt - dA/dt v.

    Args:
        manifold: of the problem.
        path: smooth, on the manifold at its nodes.
        sample_s: time between samples [s].
        shares: of speed and acceleration limits to use.

    Returns:
        The trajectory, or None if a sample could not be projected or keeps no limit.
    """
    robot = manifold.robot
    speed, acceleration = shares[0] * robot.velocity_max, shares[1] * robot.acceleration_max
    duration = least_duration(path, speed, acceleration)
    for _ in range(ROUNDS):
        count = max(int(np.ceil(duration / sample_s - 1e-9)), 2)
        timed = _sample(manifold, path, count, sample_s)
        if timed is None:
            return None
        excess = max(timed.speed_share / shares[0], timed.acceleration_share / shares[1])
        if excess <= 1.0:
            return replace(timed, drift=_drift(manifold, timed.q, timed.s))
        duration = count * sample_s * max(excess**0.5, excess, 1.0 + 1e-3)
    return None


def _sample(
    manifold: Manifold, path: SmoothPath, count: int, sample_s: float
) -> JointTrajectory | None:
    robot, tool = manifold.robot, manifold.tool
    duration = count * sample_s
    tau = np.arange(count + 1) / count
    u, rate, change = time_law(tau)
    rate, change = rate / duration, change / duration**2
    (q, s), (q_1, s_1), (q_2, s_2) = (path(u, order) for order in range(3))
    s = np.clip(s, 0.0, 1.0)
    v = q_1 * rate[:, None]
    a = q_2 * rate[:, None] ** 2 + q_1 * change[:, None]
    s_rate, s_change = s_1 * rate, s_2 * rate**2 + s_1 * change
    poses, twists, at_rest = [], [], np.zeros(manifold.chain.rows)
    for k in range(count + 1):
        pose = tool.pose(float(s[k]))
        moving = tool.motion(float(s[k]), float(s_rate[k]), float(s_change[k]))
        velocity = moving.linear_velocity, moving.angular_velocity
        twist = *velocity, moving.linear_acceleration, moving.angular_acceleration
        found = project(
            manifold.chain, q[k], *pose, tolerance=SAMPLE_TOLERANCE, weights=manifold.metric
        )
        if found.residual_norm > TOLERANCE:
            manifold.counts.projection += 1
            return None
        q[k] = found.q
        rates = manifold.chain.target_rate(*velocity) if tool.moves else at_rest
        v[k] = resolve(manifold.chain, rates, v[k], weights=manifold.metric)
        bias = manifold.chain.bias(v[k], *twist)
        a[k] = resolve(manifold.chain, bias, a[k], weights=manifold.metric)
        poses.append(pose)
        twists.append(twist)
    if not robot.within_limits(q, slack=1e-9):
        manifold.counts.limit += 1
        return None
    return JointTrajectory(
        time=np.linspace(0.0, duration, count + 1),
        q=q,
        v=v,
        a=a,
        s=s,
        oRtool=np.array([pose[0] for pose in poses]),
        position=np.array([pose[1] for pose in poses]),
        linear_velocity=np.array([twist[0] for twist in twists]),
        angular_velocity=np.array([twist[1] for twist in twists]),
        linear_acceleration=np.array([twist[2] for twist in twists]),
        angular_acceleration=np.array([twist[3] for twist in twists]),
        speed_share=float((np.abs(v) / robot.velocity_max).max()),
        acceleration_share=float((np.abs(a) / robot.acceleration_max).max()),
        drift=np.inf,
    )


def _drift(manifold: Manifold, q: Array, s: Array) -> float:
    """Largest error of a holding tip's place half way between samples [m]."""
    middle, at = 0.5 * (q[:-1] + q[1:]), 0.5 * (s[:-1] + s[1:])
    return max(manifold.hold_error(each, float(k)) for each, k in zip(middle, at, strict=True))
