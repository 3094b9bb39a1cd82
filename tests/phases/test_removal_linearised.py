"""Derivatives by hand of the cone-program solver against finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import PivotingTool
from pivotgait.phases.removal_linearised import Trajectory, dynamics, left_jacobian, slope
from pivotgait.phases.removal_problem import RemovalProblem, RemovalWeights


@pytest.fixture
def problem() -> RemovalProblem:
    rng = np.random.default_rng(3)
    body = PivotingTool(
        mass=0.2,
        inertia=np.diag([2e-4, 1.2e-3, 1.3e-3]),
        pivot_in_tool=np.array([0.21, 0.01, 0.015]),
        pivot=np.array([0.5, 0.1, 0.0]),
        gravity=np.array([0.1, -0.2, -9.8]),
    )
    frames = Rotation.random(3, rng=rng).as_matrix()
    return RemovalProblem(
        steps=5,
        step_s=0.02,
        body=body,
        orientation=Rotation.random(rng=rng).as_quat(),
        points=rng.normal(size=(3, 3)) * 0.05,
        frames=frames,
        friction=np.full(4, 0.6),
        normal_min=np.zeros(4),
        normal_max=np.full(4, 5.0),
        start_force=rng.normal(size=(4, 3)),
        clear_lever=np.zeros((0, 3)),
        clear_rise=np.zeros(0),
        force_rate_max=20.0,
        weights=RemovalWeights(),
    )


@pytest.fixture
def trajectory() -> Trajectory:
    rng = np.random.default_rng(4)
    return Trajectory(
        sigma=rng.normal(size=(5, 3)),
        local=rng.normal(size=(5, 3, 3)),
        rotation=Rotation.random(5, rng=rng).as_matrix(),
        omega=rng.normal(size=(5, 3)),
    )


def moved(trajectory: Trajectory, which: int, change: np.ndarray) -> Trajectory:
    rotation, omega = trajectory.rotation, trajectory.omega
    sigma, local = trajectory.sigma, trajectory.local
    if which == 0:
        rotation = Rotation.from_rotvec(change).as_matrix() @ rotation
    elif which == 1:
        omega = omega + change
    elif which == 2:
        sigma = sigma + change
    else:
        local = local + change.reshape(local.shape)
    return Trajectory(sigma, local, rotation, omega)


@pytest.mark.parametrize(("which", "size"), [(0, 3), (1, 3), (2, 3), (3, 9)])
def test_derivatives_of_the_dynamics_match_central_differences(
    problem: RemovalProblem, trajectory: Trajectory, which: int, size: int
) -> None:
    exact, step = dynamics(problem, trajectory), 1e-6
    for axis in range(size):
        change = np.zeros((5, size))
        change[:, axis] = step
        up = dynamics(problem, moved(trajectory, which, change))
        down = dynamics(problem, moved(trajectory, which, -change))
        moment = (up.moment - down.moment) / (2 * step)
        table = (up.table - down.table) / (2 * step)
        # central differences of values of order 10 with a step of 1e-6: error about 1e-8
        np.testing.assert_allclose(exact.moment_by[which][:, :, axis], moment, atol=2e-8)
        np.testing.assert_allclose(exact.table_by[which][:, :, axis], table, atol=2e-8)


@pytest.mark.parametrize("scale", [1e-6, 1e-4, 1e-3, 0.3, 3.0])
def test_left_jacobian_matches_differences_also_near_zero(scale: float) -> None:
    rng = np.random.default_rng(5)
    turn = scale * rng.normal(size=(4, 3))
    exact, step = left_jacobian(turn), 1e-6
    for axis in range(3):
        change = np.zeros(3)
        change[axis] = step
        up = Rotation.from_rotvec(turn + change) * Rotation.from_rotvec(turn).inv()
        down = Rotation.from_rotvec(turn - change) * Rotation.from_rotvec(turn).inv()
        difference = (up.as_rotvec() - down.as_rotvec()) / (2 * step)
        np.testing.assert_allclose(exact[:, :, axis], difference, atol=1e-8)


def test_slope_squared_is_the_squared_sine_and_its_derivative_is_exact() -> None:
    rng = np.random.default_rng(6)
    force = rng.normal(size=(20, 3)) + np.array([0.0, 0.0, 2.0])
    rho, derivative = slope(force)
    sine = 1.0 - (force[:, 2] / np.linalg.norm(force, axis=1)) ** 2
    np.testing.assert_allclose(np.sum(rho**2, axis=1), sine, atol=1e-14)
    step = 1e-6
    for axis in range(3):
        change = np.zeros(3)
        change[axis] = step
        difference = (slope(force + change)[0] - slope(force - change)[0]) / (2 * step)
        np.testing.assert_allclose(derivative[:, :, axis], difference, atol=1e-8)
