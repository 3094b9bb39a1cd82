"""A smooth turn of a tool about its pivot, with its derivatives by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import PivotingTool, pivot_motion
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]
AXES = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.48, 0.6, 0.64]])


@pytest.fixture
def tool() -> PivotingTool:
    """A body without any symmetry, gravity included."""
    turn = Rotation.from_euler("xyz", [0.3, -0.4, 0.5]).as_matrix()
    return PivotingTool(
        mass=0.31,
        inertia=turn @ np.diag([2e-4, 1.1e-3, 1.2e-3]) @ turn.T,
        pivot_in_tool=np.array([0.21, -0.013, 0.024]),
        pivot=np.array([0.5, 0.1, 0.004]),
        gravity=np.array([0.4, -0.3, -9.7]),
    )


def angles(time: Array) -> tuple[Array, Array, Array]:
    """Three smooth angles with their rates and accelerations, each (N, 3)."""
    pace, shift = np.array([1.3, 2.1, 0.7]), np.array([0.2, -1.0, 0.5])
    phase = pace * time[:, None] + shift
    return np.sin(phase), pace * np.cos(phase), -(pace**2) * np.sin(phase)


@pytest.fixture
def motion_at(tool: PivotingTool) -> Callable[[Array], ToolMotion]:
    """Motion at given times: R(t) = Exp(a_1 u_1) Exp(a_2 u_2) Exp(a_3 u_3)."""

    def motion(time: Array) -> ToolMotion:
        angle, rate, acceleration = angles(np.asarray(time, dtype=float))
        rotation = Rotation.identity(len(angle))
        omega, sigma = np.zeros((2, len(angle), 3))
        for place, axis in enumerate(AXES):
            world = rotation.as_matrix() @ axis
            # d/dt (rate R u) with R turning at the omega gathered so far
            sigma = sigma + acceleration[:, place, None] * world
            sigma = sigma + rate[:, place, None] * np.cross(omega, world)
            omega = omega + rate[:, place, None] * world
            rotation = rotation * Rotation.from_rotvec(angle[:, place, None] * axis)
        return pivot_motion(tool, rotation, omega, sigma)

    return motion
