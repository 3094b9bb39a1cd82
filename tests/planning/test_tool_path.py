"""The tool's path: turns about its pivot, and its rates are its derivatives."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.planning.tool_path import PivotingTool

PIVOT = np.array([0.5, 0.1, 0.0])


@pytest.fixture
def turning() -> PivotingTool:
    start = Rotation.from_rotvec((0.2, -0.4, 0.3)).as_matrix()
    return PivotingTool(start, np.array([0.3, 0.05, 0.1]), PIVOT, np.array([0.1, 0.2, -0.3]))


def test_the_pivot_stays(turning: PivotingTool) -> None:
    turn, position = turning.pose(0.0)
    in_tool = turn.T @ (PIVOT - position)
    for s in (0.3, 1.0):
        turn, position = turning.pose(s)
        np.testing.assert_allclose(position + turn @ in_tool, PIVOT, atol=1e-14)
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-14)


def test_motion_is_the_derivative(turning: PivotingTool) -> None:
    def s_of(t: float) -> float:
        return 0.2 + 0.5 * t + 0.3 * t**2

    h, moving = 1e-4, turning.motion(s_of(0.0), 0.5, 0.6)
    places = [turning.pose(s_of(t))[1] for t in (-h, 0.0, h)]
    turns = [turning.pose(s_of(t))[0] for t in (-h, h)]
    np.testing.assert_allclose((places[2] - places[0]) / (2 * h), moving.linear_velocity, atol=1e-7)
    np.testing.assert_allclose(
        (places[2] - 2 * places[1] + places[0]) / h**2, moving.linear_acceleration, atol=1e-6
    )
    spin = Rotation.from_matrix(turns[1] @ turns[0].T).as_rotvec() / (2 * h)
    np.testing.assert_allclose(spin, moving.angular_velocity, atol=1e-7)
    np.testing.assert_allclose(moving.angular_acceleration, 0.6 * turning.turn)


def test_a_resting_tool_rests() -> None:
    tool = PivotingTool.resting(np.eye(3), PIVOT)
    assert not tool.moves
    assert not np.any(tool.motion(0.5, 1.0, 1.0).linear_acceleration)
    np.testing.assert_array_equal(tool.pose(0.7)[1], PIVOT)


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(InputError, match="position"):
        PivotingTool.resting(np.eye(3), np.array([np.nan, 0.0, 0.0]))
