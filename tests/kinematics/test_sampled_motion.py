"""Speeds and accelerations of samples close the chain, start and end at rest, and converge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.kinematics import ClosedChain, differentiate, project
from pivotgait.models import Robot
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]
TURN, SHIFT = np.array([0.10, -0.12, 0.08]), np.array([0.010, -0.012, 0.008])


def law(time: Array) -> tuple[Array, Array, Array]:
    """From rest to rest in one second."""
    rate, change = (
        30.0 * (time * (1.0 - time)) ** 2,
        60.0 * time * (1.0 - time) * (1.0 - 2.0 * time),
    )
    return time**3 * (10.0 - 15.0 * time + 6.0 * time**2), rate, change


def tool_motion(time: Array, oRtool: Array, position: Array) -> ToolMotion:
    """Turned about a fixed axis and shifted along a line."""
    s, rate, change = law(time)
    return ToolMotion(
        position=position + np.outer(s, SHIFT),
        orientation=Rotation.from_matrix([pin.exp3(each * TURN) @ oRtool for each in s]).as_quat(),
        linear_velocity=np.outer(rate, SHIFT),
        angular_velocity=np.outer(rate, TURN),
        linear_acceleration=np.outer(change, SHIFT),
        angular_acceleration=np.outer(change, TURN),
    )


def sampled(grip: Any, count: int) -> tuple[ClosedChain, Array, ToolMotion, Array]:
    """The grip along the tool's motion, every sample led from the first by a smooth rule."""
    chain, time = ClosedChain(grip.robot, grip.holds[:2]), np.linspace(0.0, 1.0, count)
    tool, turn = tool_motion(time, grip.oRtool, grip.position), None
    turn, q = tool.rotation.as_matrix(), np.empty((count, grip.robot.nv))
    for k in range(count):
        end = project(chain, grip.q, turn[k], tool.position[k], tolerance=1e-12)
        assert end.converged
        q[k] = end.q
    return chain, time, tool, q


@pytest.mark.parametrize("weighted", [False, True])
def test_chain_stays_closed(grip: Any, weighted: bool) -> None:
    chain, time, tool, q = sampled(grip, 21)
    weights = np.linspace(0.5, 3.0, grip.robot.nv) if weighted else None
    v, a = differentiate(chain, time, tool, q, weights)
    assert np.abs(v).max() > 0.1  # it does move
    turn = tool.rotation.as_matrix()
    for k in range(len(time)):
        moving = tool.linear_velocity[k], tool.angular_velocity[k]
        growing = tool.linear_acceleration[k], tool.angular_acceleration[k]
        chain.update(q[k], turn[k], tool.position[k])
        np.testing.assert_allclose(chain.jacobian @ v[k], chain.target_rate(*moving), atol=1e-10)
        bias = chain.bias(v[k], *moving, *growing)
        np.testing.assert_allclose(chain.jacobian @ a[k], bias, atol=1e-9)
    np.testing.assert_allclose(v[[0, -1]], 0.0, atol=1e-10)
    np.testing.assert_allclose(a[[0, -1]], 0.0, atol=1e-10)


def test_samples_that_are_dense_give_the_motion_s_own_speeds(grip: Any) -> None:
    """Against central differences of the configurations at the common moments."""
    errors = []
    for count in (11, 41):
        chain, time, tool, q = sampled(grip, count)
        v, a = differentiate(chain, time, tool, q)
        middle, step = count // 2, 1e-3
        around = tool_motion(0.5 + step * np.arange(-2, 3), grip.oRtool, grip.position)
        ways = around.rotation.as_matrix(), around.position
        exact = [
            project(chain, grip.q, *each, tolerance=1e-12).q for each in zip(*ways, strict=True)
        ]
        speed = np.tensordot([1.0, -8.0, 0.0, 8.0, -1.0], exact, axes=1) / (12.0 * step)
        growth = np.tensordot([-1.0, 16.0, -30.0, 16.0, -1.0], exact, axes=1) / (12.0 * step**2)
        errors.append((np.abs(v[middle] - speed).max(), np.abs(a[middle] - growth).max()))
    coarse, fine = errors
    assert fine[0] < 1e-5  # [rad/s]
    assert fine[1] < 1e-3  # [rad/s^2]; the differences' own rounding is 1e-6
    assert fine[0] < coarse[0] / 20.0
    assert fine[1] < coarse[1] / 5.0


@pytest.mark.parametrize(("count", "speed", "growth"), [(26, 3e-5, 5e-3), (101, 2e-7, 1e-4)])
def test_without_holds_the_joints_own_derivatives(
    robot: Robot, count: int, speed: float, growth: float
) -> None:
    time, way = np.linspace(0.0, 1.0, count), np.linspace(-1.0, 1.0, robot.nv)
    s, rate, change = law(time)
    tool = tool_motion(time, np.eye(3), np.zeros(3))
    v, a = differentiate(ClosedChain(robot, ()), time, tool, np.outer(s, way))
    np.testing.assert_allclose(v, np.outer(rate, way), atol=speed)
    np.testing.assert_allclose(a, np.outer(change, way), atol=growth)
