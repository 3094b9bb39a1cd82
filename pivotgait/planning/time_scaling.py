"""Timing of a smooth path under joint speed and acceleration limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.kinematics import RigidMotion, differentiate, project
from pivotgait.planning.manifold import TOLERANCE, Manifold
from pivotgait.planning.smoothing import SmoothPath
from pivotgait.planning.trajectory import JointTrajectory
from pivotgait.plans import ToolMotion

GRID = 400
"""Moments at which a motion of unit length is looked at for its limits."""
SAMPLE_TOLERANCE = 1e-12
"""Of eq. (9) at samples [m]: what is left of it makes the speeds rough."""
ROUNDING = 5e-10
"""Of positions [rad], [m] and speeds."""
ROUNDS = 8
"""Of slowing down, when corrections on the manifold have raised speeds, and of denser samples."""


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

    Every sample is projected on eq. (9); v and a follow from the samples by
    :func:`pivotgait.kinematics.differentiate`.

    Args:
        manifold: of the problem.
        path: smooth, on the manifold at its nodes.
        sample_s: time between samples [s]; halved while the curve turns between two.
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
        if excess > 1.0:
            duration = count * sample_s * max(excess**0.5, excess, 1.0 + 1e-3)
        elif not _resolved(timed):
            sample_s *= 0.5
        else:
            return replace(timed, drift=_drift(manifold, timed.q, timed.s))
    return None


def _resolved(timed: JointTrajectory) -> bool:
    """Whether the samples are dense enough for the curve: the trapezoid rule joins q, v and a.

    Over a step h it is off by h^2 |da| / 8 and h |da| / 2 at most where a changes by da within a
    step; more means that the curve turns between samples.
    """
    h = float(timed.time[1] - timed.time[0])
    jump = np.pad(np.abs(np.diff(timed.a, axis=0)), ((1, 1), (0, 0)), mode="edge")
    jump = jump[:-2] + jump[1:-1] + jump[2:]
    step = np.abs(np.diff(timed.q, axis=0) - 0.5 * h * (timed.v[:-1] + timed.v[1:]))
    rate = np.abs(np.diff(timed.v, axis=0) - 0.5 * h * (timed.a[:-1] + timed.a[1:]))
    step_allowed, rate_allowed = h**2 * jump / 8.0 + ROUNDING, 0.5 * h * jump + ROUNDING
    return bool(np.all(step <= step_allowed) and np.all(rate <= rate_allowed))


def _sample(
    manifold: Manifold, path: SmoothPath, count: int, sample_s: float
) -> JointTrajectory | None:
    robot, tool = manifold.robot, manifold.tool
    duration = count * sample_s
    tau = np.arange(count + 1) / count
    u, rate, change = time_law(tau)
    rate, change = rate / duration, change / duration**2
    (q, s), (_, s_1), (_, s_2) = (path(u, order) for order in range(3))
    s = np.clip(s, 0.0, 1.0)
    s_rate, s_change = s_1 * rate, s_2 * rate**2 + s_1 * change
    poses, moving = [], []
    for k in range(count + 1):
        pose = tool.pose(float(s[k]))
        moving.append(tool.motion(float(s[k]), float(s_rate[k]), float(s_change[k])))
        found = project(
            manifold.chain, q[k], *pose, tolerance=SAMPLE_TOLERANCE, weights=manifold.metric
        )
        if found.residual_norm > TOLERANCE:
            manifold.counts.projection += 1
            return None
        q[k] = found.q
        poses.append(pose)
    if not robot.within_limits(q, slack=1e-9):
        manifold.counts.limit += 1
        return None
    time = np.linspace(0.0, duration, count + 1)
    motion = _tool_motion(poses, moving)
    v, a = differentiate(manifold.chain, time, motion, q, weights=manifold.metric)
    return JointTrajectory(
        time=time,
        q=q,
        v=v,
        a=a,
        s=s,
        tool=motion,
        speed_share=float((np.abs(v) / robot.velocity_max).max()),
        acceleration_share=float((np.abs(a) / robot.acceleration_max).max()),
        drift=np.inf,
    )


def _tool_motion(poses: list[tuple[Array, Array]], moving: list[RigidMotion]) -> ToolMotion:
    return ToolMotion(
        position=np.array([position for _, position in poses]),
        orientation=Rotation.from_matrix([turn for turn, _ in poses]).as_quat(canonical=True),
        linear_velocity=np.array([each.linear_velocity for each in moving]),
        angular_velocity=np.array([each.angular_velocity for each in moving]),
        linear_acceleration=np.array([each.linear_acceleration for each in moving]),
        angular_acceleration=np.array([each.angular_acceleration for each in moving]),
    )


def _drift(manifold: Manifold, q: Array, s: Array) -> float:
    """Largest error of a holding tip's place half way between samples [m]."""
    middle, at = 0.5 * (q[:-1] + q[1:]), 0.5 * (s[:-1] + s[1:])
    return max(manifold.hold_error(each, float(k)) for each, k in zip(middle, at, strict=True))
