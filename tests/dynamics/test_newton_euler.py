"""Newton-Euler (eq. 3) against the derivatives of momentum, and the balance of energy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import simpson
from scipy.spatial.transform import Rotation

from pivotgait.contacts import grasp_map
from pivotgait.dynamics import (
    PivotingTool,
    pivot_dynamics,
    pivot_motion,
    required_wrench,
    world_inertia,
)
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]
Motion = Callable[[Array], ToolMotion]
TIME = np.linspace(0.0, 4.0, 41)
STEP = 1e-5


def momentum(tool: PivotingTool, motion: ToolMotion) -> Array:
    """(N, 6) linear momentum, and angular momentum about the centre of mass."""
    inertia = world_inertia(tool.inertia, motion.rotation)
    spin = np.einsum("nij,nj->ni", inertia, motion.angular_velocity)
    return np.hstack((tool.mass * motion.linear_velocity, spin))


def test_wrench_is_the_rate_of_momentum_less_the_weight(
    tool: PivotingTool, motion_at: Motion
) -> None:
    before, after = momentum(tool, motion_at(TIME - STEP)), momentum(tool, motion_at(TIME + STEP))
    rate = (after - before) / (2 * STEP)
    rate[:, :3] -= tool.mass * tool.gravity
    # momenta of order 0.1 with third derivatives below 10: h^2 f''' / 6 < 2e-10, rounding 1e-12
    np.testing.assert_allclose(required_wrench(tool, motion_at(TIME)), rate, atol=1e-9)


def test_pivot_dynamics_say_the_same(tool: PivotingTool, motion_at: Motion) -> None:
    motion = motion_at(TIME)
    mass, bias = pivot_dynamics(tool, motion.rotation, motion.angular_velocity)
    wrench = np.einsum("nij,nj->ni", mass, motion.angular_acceleration) + bias
    # forces of up to 4 N from a dozen products: rounding
    np.testing.assert_allclose(wrench, required_wrench(tool, motion), atol=1e-14)


def test_at_rest_the_contacts_carry_the_weight_and_no_moment(tool: PivotingTool) -> None:
    rotation = Rotation.random(6, rng=np.random.default_rng(4))
    motion = pivot_motion(tool, rotation, np.zeros((6, 3)), np.zeros((6, 3)))
    wrench = required_wrench(tool, motion)
    np.testing.assert_array_equal(wrench[:, :3], np.tile(-tool.mass * tool.gravity, (6, 1)))
    np.testing.assert_array_equal(wrench[:, 3:], np.zeros((6, 3)))


def test_falling_freely_needs_nothing(tool: PivotingTool, motion_at: Motion) -> None:
    motion = motion_at(TIME)
    fall = replace(
        motion,
        linear_acceleration=np.tile(tool.gravity, (41, 1)),
        angular_velocity=np.zeros((41, 3)),
        angular_acceleration=np.zeros((41, 3)),
    )
    np.testing.assert_array_equal(required_wrench(tool, fall), np.zeros((41, 6)))


def test_steady_turn_about_a_principal_axis_needs_no_moment(tool: PivotingTool) -> None:
    _, axes = np.linalg.eigh(tool.inertia)
    rotation = Rotation.random(3, rng=np.random.default_rng(5))
    omega = 4.0 * np.einsum("nij,nj->ni", rotation.as_matrix(), axes.T)
    motion = pivot_motion(tool, rotation, omega, np.zeros((3, 3)))
    moment = required_wrench(tool, motion)[:, 3:]
    # |I| omega^2 = 0.02 N m cancels to rounding
    np.testing.assert_allclose(moment, 0.0, atol=1e-16)


def test_inertia_turns_with_the_tool(tool: PivotingTool) -> None:
    rotation = Rotation.random(20, rng=np.random.default_rng(6))
    inertia = world_inertia(tool.inertia, rotation)
    np.testing.assert_allclose(inertia, np.swapaxes(inertia, 1, 2), atol=1e-18)
    expected = np.tile(np.linalg.eigvalsh(tool.inertia), (20, 1))
    np.testing.assert_allclose(np.linalg.eigvalsh(inertia), expected, rtol=1e-12)


def test_work_of_the_contacts_is_the_change_of_energy(
    tool: PivotingTool, motion_at: Motion
) -> None:
    time = np.linspace(0.0, 2.0, 2001)
    motion = motion_at(time)
    wrench = required_wrench(tool, motion)
    twist = np.hstack((motion.linear_velocity, motion.angular_velocity))
    kinetic = 0.5 * np.sum(momentum(tool, motion) * twist, axis=1)
    energy = kinetic - tool.mass * motion.position @ tool.gravity
    work = simpson(np.sum(wrench * twist, axis=1), x=time)
    # Simpson with h = 1e-3: h^4 f'''' / 180 * 2 s, f'''' below 1e3 W/s^4: 1e-11 J
    assert energy[-1] - energy[0] == pytest.approx(work, abs=1e-10)
    assert abs(work) > 1e-3  # or the law would say nothing here


def test_the_pivot_does_no_work(tool: PivotingTool, motion_at: Motion) -> None:
    # whatever its force is: so the power of fingers alone changes the energy
    motion = motion_at(TIME)
    rng = np.random.default_rng(8)
    points = np.vstack((tool.pivot_in_tool, rng.normal(scale=0.05, size=(3, 3))))
    lever = np.einsum("nij,mj->nmi", motion.rotation.as_matrix(), points)
    g, wrench = grasp_map(lever), required_wrench(tool, motion)
    force = rng.normal(size=(41, 12))
    missing = wrench - np.einsum("nij,nj->ni", g, force)
    force += np.einsum("nij,nj->ni", np.linalg.pinv(g), missing)
    velocity = motion.linear_velocity[:, None] + np.cross(motion.angular_velocity[:, None], lever)
    power = np.einsum("nmi,nmi->nm", force.reshape(41, 4, 3), velocity)
    twist = np.hstack((motion.linear_velocity, motion.angular_velocity))
    # forces of order 10 N at 0.5 m/s through a pseudo-inverse of condition 100
    np.testing.assert_allclose(power[:, 0], 0.0, atol=1e-13)
    np.testing.assert_allclose(power[:, 1:].sum(axis=1), np.sum(wrench * twist, 1), atol=1e-11)


def test_equations_hold_in_every_frame(tool: PivotingTool, motion_at: Motion) -> None:
    turn = Rotation.from_euler("xyz", [0.5, 1.0, -2.0])
    motion, matrix = motion_at(TIME), turn.as_matrix()
    other = replace(tool, gravity=matrix @ tool.gravity, pivot=matrix @ tool.pivot)
    turned = pivot_motion(
        other,
        turn * motion.rotation,
        motion.angular_velocity @ matrix.T,
        motion.angular_acceleration @ matrix.T,
    )
    wrench = required_wrench(tool, motion).reshape(-1, 2, 3) @ matrix.T
    np.testing.assert_allclose(required_wrench(other, turned).reshape(-1, 2, 3), wrench, atol=1e-14)
