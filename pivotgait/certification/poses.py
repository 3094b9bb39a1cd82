"""Robot and tool at the samples of a phase and halfway between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plans import Phase, RobotMotion


@dataclass(frozen=True, eq=False)
class Poses(FrozenArrays):
    """Samples of a phase with the middles between them: M = 2 N - 1 poses of robot and tool.

    Attributes:
        time: (M,) [s].
        q: (M, n) joint positions.
        position: (M, 3) of the tool's centre of mass, world [m].
        orientation: (M, 4) unit quaternion xyzw, world <- tool.
    """

    time: Array
    q: Array
    position: Array
    orientation: Array


def with_middles(phase: Phase, motion: RobotMotion) -> Poses:
    """Poses at the samples and in the middles of the steps.

    Joints and the tool's position follow the cubic with the steps' ends and their velocities, the
    tool's orientation its shortest turn.
    """
    tool, time = phase.tool, phase.time
    h = np.diff(time)
    middle = time[:-1] + 0.5 * h
    q, v = motion.q, motion.v
    q_middle = 0.5 * (q[:-1] + q[1:]) + h[:, None] / 8.0 * (v[:-1] - v[1:])
    speed = tool.linear_velocity
    position = 0.5 * (tool.position[:-1] + tool.position[1:])
    position = position + h[:, None] / 8.0 * (speed[:-1] - speed[1:])
    # Quaternions in a file are near unit length, and these are exactly.
    unit = tool.rotation.as_quat()
    turned = Slerp(time, Rotation.from_quat(unit))(middle).as_quat()
    return Poses(
        woven(time, middle),
        woven(q, q_middle),
        woven(tool.position, position),
        woven(unit, turned),
    )


def woven(at: Array, between: Array) -> Array:
    """(2 N - 1, ...) values at N samples and between them, in turn."""
    both = np.empty((len(at) + len(between), *at.shape[1:]))
    both[::2], both[1::2] = at, between
    return both
