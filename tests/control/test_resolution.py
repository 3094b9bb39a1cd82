"""Limits hold, ways join, and a singular task does not shake the joints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pivotgait.control import FeedForwardController, HybridController, Measurement, Reference
from pivotgait.control.joint_limits import HORIZON, JointLimits
from pivotgait.forces.resolution_qp import ResolutionQp

Read = Callable[..., Measurement]


@pytest.mark.parametrize("scale", [1e-3, 0.1])
def test_torques_keep_their_limits(reference: Reference, read: Read, scale: float) -> None:
    law = HybridController(reference)
    rng = np.random.default_rng(4)
    effort = reference.robot.effort_max
    for _ in range(20):
        reading = read(0.3, off=scale * rng.normal(size=reference.robot.nv), more=2.0)
        assert np.all(np.abs(law.torque(reading)) <= effort * (1.0 + 1e-6))


def test_wild_errors_go_to_the_program(reference: Reference, read: Read) -> None:
    law = HybridController(reference)
    law.torque(read(0.3))
    assert law.resolution.cycles[2] == 0
    law.torque(read(0.3, v_off=50.0))
    assert law.resolution.cycles[2] == 1
    law.reset()
    assert law.resolution.cycles == [0, 0, 0]


def test_near_a_singular_task_the_planned_motion_remains(reference: Reference, read: Read) -> None:
    """Any task, H = 0 among them: at the plan, the joints accelerate as planned."""
    law = FeedForwardController(reference)
    reading, wanted = read(0.3), reference.at(0.3)
    law.torque(reading)
    task = law.tasks[0]
    zero = np.zeros(reference.robot.nv)
    task.matrix[:] = 0.0
    tau = law.resolution.torque(task, zero, wanted.a, reading.q, reading.v, zero)
    task.update(reading.q, reading.v, wanted)
    regular = law.resolution.torque(
        task, task.matrix @ wanted.a, wanted.a, reading.q, reading.v, zero
    )
    np.testing.assert_allclose(tau, regular, atol=1e-8)


def test_bounds_lead_back_from_a_limit(reference: Reference) -> None:
    robot = reference.robot
    limits = JointLimits(robot)
    rest = np.zeros(robot.nv)
    lower, upper = limits.acceleration_bounds(robot.upper + 0.01, rest)
    assert np.all(upper < 0.0)
    assert np.all(lower <= upper)
    after = robot.upper + 0.01 + 0.5 * HORIZON**2 * upper
    np.testing.assert_allclose(after, robot.upper, atol=1e-12)
    lower, upper = limits.acceleration_bounds(robot.lower - 0.01, rest)
    assert np.all(lower > 0.0)
    fast = limits.acceleration_bounds(robot.home, 2.0 * robot.velocity_max)[1]
    assert np.all(fast < 0.0)


def test_the_program_agrees_with_its_conditions() -> None:
    rng = np.random.default_rng(2)
    matrix = rng.normal(size=(6, 6))
    hessian, slope = matrix @ matrix.T + np.eye(6), 10.0 * rng.normal(size=6)
    program = ResolutionQp(6, 6)
    for _ in range(3):
        x = program.solve(hessian, slope, np.eye(6), -np.ones(6), np.ones(6))
        assert x is not None
        gradient = hessian @ x + slope
        free = np.abs(x) < 1.0 - 1e-5
        assert np.all(np.abs(x) <= 1.0 + 1e-5)
        assert np.any(~free)
        np.testing.assert_allclose(gradient[free], 0.0, atol=1e-4)
        assert np.all(gradient[~free] * x[~free] < 1e-4)
        slope = slope + 0.1


def test_no_point_within_limits_is_told() -> None:
    program = ResolutionQp(1, 2)
    rows = np.array([[1.0], [1.0]])
    found = program.solve(
        np.eye(1), np.zeros(1), rows, np.array([1.0, -2.0]), np.array([2.0, -1.0])
    )
    assert found is None
