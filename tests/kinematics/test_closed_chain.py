"""The closed chain's residual means contact, and its derivatives are exact."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.kinematics import ClosedChain, RigidMotion, resolve
from pivotgait.kinematics.local_coordinates import SMALLEST_COS_PSI
from pivotgait.models import Robot

Array = NDArray[np.float64]
Differences = Callable[[Callable[[float], Array]], tuple[Array, Array]]
EDGE = float(np.arccos(SMALLEST_COS_PSI))


def turn_z(angle: float) -> Array:
    return pin.exp3(np.array([0.0, 0.0, angle]))


def coordinates(chain: ClosedChain) -> Array:
    return np.concatenate([finger.value for finger in chain.fingers])


@pytest.mark.parametrize("fingers", [1, 2, 3])
def test_jacobian_is_the_derivative_of_the_residual(
    grip: Any, fingers: int, differences: Differences
) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds[:fingers]), grip.near()
    chain.update(q, grip.oRtool, grip.position)
    jacobian, six = chain.jacobian.copy(), np.concatenate([f.jacobian for f in chain.fingers])
    for column in range(grip.robot.nv):
        step = np.eye(grip.robot.nv)[column]

        def both(time: float, step: Array = step) -> Array:
            chain.update(q + time * step, grip.oRtool, grip.position)
            return np.concatenate((chain.residual, coordinates(chain)))

        numeric = differences(both)[0]
        analytic = np.concatenate((jacobian[:, column], six[:, column]))
        np.testing.assert_allclose(analytic, numeric, atol=2e-9)


def along(chain: ClosedChain, grip: Any, q: Array, motion: Any) -> Callable[[float], Array]:
    """Residual, then all coordinates (angles unwrapped), of a chain along a motion."""
    chain.update(q, grip.oRtool, grip.position)
    start = coordinates(chain)

    def values(time: float) -> Array:
        chain.update(*grip.moved(q, motion, time))
        change = coordinates(chain) - start
        return np.concatenate((chain.residual, change - 2.0 * np.pi * np.round(change / 6.28)))

    return values


@pytest.mark.parametrize("fingers", [1, 3])
@pytest.mark.parametrize(
    ("psi", "theta"), [(0.0, 0.0), (0.0, np.pi), (0.7, -np.pi), (-1.2, 0.5), (0.9 * EDGE, 2.0)]
)
def test_rates_and_accelerations_with_a_moving_tool(
    grip: Any, fingers: int, psi: float, theta: float, differences: Differences
) -> None:
    chain = ClosedChain(grip.robot, grip.turned(psi, theta)[:fingers])
    q, motion = grip.near(0.01), grip.motion()
    first, second = differences(along(chain, grip, q, motion))
    chain.update(q, grip.oRtool, grip.position)
    tool = RigidMotion(*motion.tool)
    b = chain.target_rate(*motion.tool[:2])
    bias = chain.bias(motion.v, *motion.tool)
    rate = [f.jacobian @ motion.v - f.target_rate(tool) for f in chain.fingers]
    acceleration = [f.jacobian @ motion.a + f.drift(motion.v, tool) for f in chain.fingers]
    np.testing.assert_allclose(
        np.concatenate((chain.jacobian @ motion.v - b, *rate)), first, rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(
        np.concatenate((chain.jacobian @ motion.a - bias, *acceleration)),
        second,
        rtol=1e-5,
        atol=1e-4,
    )


def test_residual_vanishes_in_the_grip(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    chain.update(grip.q, grip.oRtool, grip.position)
    np.testing.assert_allclose(chain.residual, 0.0, atol=1e-14)


def test_residual_measures_the_tips_distance_and_tilt(grip: Any) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds), grip.near()
    chain.update(q, grip.oRtool, grip.position)
    data = grip.robot.model.createData()
    pin.forwardKinematics(grip.robot.model, data, q)
    pin.updateFramePlacements(grip.robot.model, data)
    for hold, (psi, phi, *error) in zip(grip.holds, chain.residual.reshape(-1, 5), strict=True):
        tip = data.oMf[hold.finger.tip_frame_id]
        centre = grip.position + grip.oRtool @ hold.centre
        axis, normal = tip.rotation @ hold.axis_in_tip, grip.oRtool @ hold.normal
        distance = float(np.linalg.norm(tip.translation - centre))
        assert np.linalg.norm(error) == pytest.approx(distance, abs=1e-15)
        # The axis in T is (sin psi, -sin phi cos psi, cos phi cos psi).
        assert np.cos(psi) * np.cos(phi) == pytest.approx(axis @ normal, abs=1e-14)
        depth = (tip.translation - centre) @ normal
        assert error[2] == pytest.approx(depth, abs=1e-15)


@pytest.mark.parametrize("spin", [0.3, -2.0, np.pi])
def test_spin_of_the_fingertip_leaves_the_residual(grip: Any, spin: float) -> None:
    spun = [replace(h, tipRcontact=h.tipRcontact @ turn_z(spin)) for h in grip.holds]
    one, other = ClosedChain(grip.robot, grip.holds), ClosedChain(grip.robot, spun)
    q = grip.near()
    for chain in (one, other):
        chain.update(q, grip.oRtool, grip.position)
    np.testing.assert_allclose(one.residual, other.residual, atol=1e-14)
    np.testing.assert_allclose(one.jacobian, other.jacobian, atol=1e-13)
    for before, after in zip(one.fingers, other.fingers, strict=True):
        change = after.value[0] - before.value[0] - spin
        assert np.cos(change) == pytest.approx(1.0, abs=1e-14)


def test_spin_of_the_tool_about_the_normal_leaves_the_hold(grip: Any) -> None:
    hold = grip.holds[0]
    centre = grip.position + grip.oRtool @ hold.centre
    turn = pin.exp3(0.8 * (grip.oRtool @ hold.normal))
    chain = ClosedChain(grip.robot, [hold])
    chain.update(grip.q, turn @ grip.oRtool, centre + turn @ (grip.position - centre))
    np.testing.assert_allclose(chain.residual, 0.0, atol=1e-14)


def test_nothing_changes_when_everything_moves_together(grip: Any) -> None:
    """A turn about the arm's vertical first axis carries robot and tool alike."""
    chain, q, turn = ClosedChain(grip.robot, grip.holds), grip.near(), turn_z(0.6)
    chain.update(q, grip.oRtool, grip.position)
    before = chain.residual.copy()
    turned = q + 0.6 * np.eye(grip.robot.nv)[0]
    chain.update(turned, turn @ grip.oRtool, turn @ grip.position)
    np.testing.assert_allclose(chain.residual, before, atol=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_tip_at_a_right_angle_is_refused(grip: Any, sign: float) -> None:
    inside, beyond = (
        ClosedChain(grip.robot, grip.turned(sign * psi, 0.4)) for psi in (0.999 * EDGE, 1.56)
    )
    inside.update(grip.q, grip.oRtool, grip.position)
    assert np.all(np.isfinite(inside.jacobian))
    with pytest.raises(SingularCoordinatesError, match="thtip"):
        beyond.update(grip.q, grip.oRtool, grip.position)


def drift_after(grip: Any, steps: int) -> float:
    """Residual after half a second of a turning, shifting tool; midpoint rule, no projection."""
    chain = ClosedChain(grip.robot, grip.holds[:2])
    axis, shift = np.array([0.2, -0.3, 0.4]), np.array([0.02, 0.03, -0.01])
    step = 0.5 / steps

    def pose(time: float) -> tuple[Array, Array]:
        return pin.exp3(time**2 * axis) @ grip.oRtool, grip.position + time**2 * shift

    def speed(q: Array, time: float) -> Array:
        chain.update(q, *pose(time))
        b = chain.target_rate(2.0 * time * shift, 2.0 * time * axis)
        return resolve(chain, b, np.zeros(grip.robot.nv))

    q = grip.q
    for k in range(steps):
        middle = q + 0.5 * step * speed(q, k * step)
        q = q + step * speed(middle, (k + 0.5) * step)
    chain.update(q, *pose(0.5))
    return float(np.linalg.norm(chain.residual))


def test_integrated_velocities_follow_the_tool(grip: Any) -> None:
    coarse, fine = drift_after(grip, 20), drift_after(grip, 40)
    assert coarse < 1e-3
    # Second order: a step half as long leaves a quarter of the drift.
    assert 3.0 < coarse / fine < 5.5


def test_chain_without_holds_is_empty(robot: Robot) -> None:
    chain = ClosedChain(robot, [])
    chain.update(robot.home, np.eye(3), np.zeros(3))
    assert chain.residual.shape == (0,)
    assert chain.jacobian.shape == (0, robot.nv)
    assert chain.row_lengths().shape == (0,)


def test_copy_is_independent(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    chain.update(grip.near(), grip.oRtool, grip.position)
    before, twin = chain.residual.copy(), copy.copy(chain)
    twin.update(grip.q, grip.oRtool, grip.position)
    assert twin.holds == chain.holds
    np.testing.assert_allclose(twin.residual, 0.0, atol=1e-14)
    np.testing.assert_array_equal(chain.residual, before)


def test_chain_keeps_its_own_configuration(grip: Any) -> None:
    chain, q, motion = ClosedChain(grip.robot, grip.holds), grip.near(), grip.motion()
    chain.update(q, grip.oRtool, grip.position)
    before = chain.bias(motion.v, *motion.tool)
    q[:] = 0.0
    np.testing.assert_array_equal(chain.bias(motion.v, *motion.tool), before)


@pytest.mark.parametrize("length", [None, 0.03])
def test_row_lengths_turn_angles_into_lengths(grip: Any, length: float | None) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    scales = chain.row_lengths(length).reshape(-1, 5)
    for hold, scale in zip(grip.holds, scales, strict=True):
        angle = hold.finger.tip_radius if length is None else length
        np.testing.assert_array_equal(scale, [angle, angle, 1.0, 1.0, 1.0])
