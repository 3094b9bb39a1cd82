"""Kinematics of the pivoting tool (eqs 1-2) against finite differences of a smooth R(t)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import PivotingTool, pivot_motion
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]
Motion = Callable[[Array], ToolMotion]
TIME = np.linspace(0.0, 4.0, 41)
STEP = 1e-5
DIFFERENCE = 1e-9
"""Central differences of values of order 1: h^2 f''' / 6 < 2e-10, rounding 1e-16 / h = 1e-11."""


def test_angular_velocity_is_the_derivative_of_the_orientation(motion_at: Motion) -> None:
    before, after = motion_at(TIME - STEP).rotation, motion_at(TIME + STEP).rotation
    omega = (after * before.inv()).as_rotvec() / (2 * STEP)
    np.testing.assert_allclose(motion_at(TIME).angular_velocity, omega, atol=1e-8)


@pytest.mark.parametrize(
    ("value", "derivative"),
    [
        ("position", "linear_velocity"),
        ("linear_velocity", "linear_acceleration"),
        ("angular_velocity", "angular_acceleration"),
    ],
)
def test_rates_are_derivatives(motion_at: Motion, value: str, derivative: str) -> None:
    before, after = motion_at(TIME - STEP), motion_at(TIME + STEP)
    difference = (getattr(after, value) - getattr(before, value)) / (2 * STEP)
    exact = getattr(motion_at(TIME), derivative)
    # rates of up to 2.1 rad/s: third derivatives below 100, so h^2 f''' / 6 < 2e-9
    np.testing.assert_allclose(exact, difference, atol=5 * DIFFERENCE)


def test_the_pivot_stays_where_it_is(tool: PivotingTool, motion_at: Motion) -> None:
    motion = motion_at(TIME)
    arm = motion.rotation.as_matrix() @ tool.pivot_in_tool
    np.testing.assert_allclose(motion.position + arm, np.tile(tool.pivot, (41, 1)), atol=1e-15)
    velocity = motion.linear_velocity + np.cross(motion.angular_velocity, arm)
    np.testing.assert_allclose(velocity, 0.0, atol=1e-15)


def test_the_centre_of_mass_keeps_its_distance_from_the_pivot(
    tool: PivotingTool, motion_at: Motion
) -> None:
    distance = np.linalg.norm(motion_at(TIME).position - tool.pivot, axis=1)
    np.testing.assert_allclose(distance, np.linalg.norm(tool.pivot_in_tool), rtol=1e-14)


def test_a_steady_turn_has_only_centripetal_acceleration(tool: PivotingTool) -> None:
    axis, speed = np.array([0.0, 0.0, 1.0]), 2.0
    rotation = Rotation.from_rotvec(np.linspace(0.0, 1.0, 5)[:, None] * axis)
    omega = np.tile(speed * axis, (5, 1))
    motion = pivot_motion(tool, rotation, omega, np.zeros((5, 3)))
    inward = tool.pivot - motion.position
    inward[:, 2] = 0.0
    np.testing.assert_allclose(motion.linear_acceleration, speed**2 * inward, atol=1e-14)


def test_turning_about_the_tools_own_axis_moves_nothing_else(tool: PivotingTool) -> None:
    rotation = Rotation.from_euler("ZYX", [[0.4, 0.3, 0.2]])
    along = rotation.as_matrix() @ tool.pivot_in_tool
    motion = pivot_motion(tool, rotation, 3.0 * along, -2.0 * along)
    np.testing.assert_allclose(motion.linear_velocity, 0.0, atol=1e-16)
    np.testing.assert_allclose(motion.linear_acceleration, 0.0, atol=1e-16)


def test_arrays_of_the_tool_are_copies_that_cannot_change(tool: PivotingTool) -> None:
    given = np.eye(3)
    copy = PivotingTool(1.0, given, np.ones(3), np.zeros(3), np.zeros(3))
    given[0, 0] = 5.0
    assert copy.inertia[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        tool.pivot[0] = 1.0
