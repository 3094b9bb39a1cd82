"""Kinematics of a tool that turns about its pivot (Xue et al., eqs 1-2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.frozen import FrozenArrays
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PivotingTool(FrozenArrays):
    """The rigid body of Section III: a tool whose tip stays at one point of the table.

    Attributes:
        mass: [kg].
        inertia: (3, 3) at the centre of mass, tool frame [kg m^2].
        pivot_in_tool: (3,) pivot relative to the centre of mass, tool frame [m] (b_c0).
        pivot: (3,) pivot in the world frame [m] (c0).
        gravity: (3,) world frame [m/s^2].
    """

    mass: float
    inertia: Array
    pivot_in_tool: Array
    pivot: Array
    gravity: Array

    @property
    def inertia_about_pivot(self) -> Array:
        """(3, 3) inertia about the pivot, tool axes [kg m^2] (parallel axes)."""
        arm = self.pivot_in_tool
        return np.asarray(self.inertia + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))


def pivot_motion(
    tool: PivotingTool,
    rotation: Rotation,
    angular_velocity: Array,
    angular_acceleration: Array,
) -> ToolMotion:
    """Motion of the centre of mass that follows from turning about the pivot.

    With r = R_o b_c0: o = c0 - r (eq. 1), v = -omega x r, and
    v' = -[omega']x r - [omega]x [omega]x r (eq. 2).

    Args:
        tool: the body and its pivot.
        rotation: N orientations, world <- tool.
        angular_velocity: (N, 3) world [rad/s].
        angular_acceleration: (N, 3) world [rad/s^2].

    Returns:
        The motion at the N samples.
    """
    omega = np.asarray(angular_velocity, dtype=float)
    sigma = np.asarray(angular_acceleration, dtype=float)
    arm = rotation.as_matrix() @ tool.pivot_in_tool
    velocity = -np.cross(omega, arm)
    return ToolMotion(
        position=tool.pivot - arm,
        orientation=rotation.as_quat(),
        linear_velocity=velocity,
        angular_velocity=omega,
        linear_acceleration=-np.cross(sigma, arm) + np.cross(omega, velocity),
        angular_acceleration=sigma,
    )
