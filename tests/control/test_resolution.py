"""Limits hold, ways join, and a singular task does not shake the joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.control import FeedForwardController, HybridController, Measurement, Reference
from pivotgait.control.joint_limits import HORIZON, JointLimits
from pivotgait.control.resistance import Resistance
from pivotgait.control.task_controller import contact_load
from pivotgait.forces.resolution_qp import ResolutionQp
from pivotgait.frozen import Array

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
    tau = law.resolution.torque(task, zero, wanted.a, reading, zero)
    task.update(reading.q, reading.v, wanted)
    regular = law.resolution.torque(task, task.matrix @ wanted.a, wanted.a, reading, zero)
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


def test_a_joint_held_by_friction_is_pushed_past_its_speed_bound(
    reference: Reference, read: Read
) -> None:
    """At rest the speed limit allows 1,000 rad/s^2; friction of 1,500 must not stop it for good."""
    robot = reference.robot
    middle = robot.joint_names.index("MFJ1")
    off = np.zeros(robot.nv)
    off[middle] = -0.15  # K_p = 1e4 / s^2 asks for 1,500 rad/s^2
    bound, free = HybridController(reference), HybridController(reference)
    free.resolution.limits = JointLimits(replace(robot, velocity_max=np.full(robot.nv, 1e4)))
    readings = [read(0.3 + 1e-3 * k, off=off) for k in range(100)]
    asked = np.array([[_push(law, each)[middle] for law in (free, bound)] for each in readings])
    assert bound.resolution.cycles[2] > 0
    assert asked[0, 1] < 0.8 * asked[0, 0]
    assert asked[-1, 1] == pytest.approx(asked[-1, 0], rel=0.02)


def _push(law: HybridController, reading: Measurement) -> Array:
    """(n,) accelerations that the law's torques give to joints that nothing touches."""
    robot, tau = law.reference.robot, law.torque(reading)
    data = robot.model.createData()
    wanted = law.reference.at(reading.time)
    task = law.tasks[wanted.phase]
    load = contact_load(task, wanted, reading.tool_rotation) + law._joint_damping * wanted.v
    return np.asarray(pin.aba(robot.model, data, reading.q, reading.v, tau - load))


def test_resistance_is_what_did_not_come() -> None:
    resistance, v = Resistance(2), np.zeros(2)
    for k in range(200):
        resistance.observe(1e-3 * k, v)
        resistance.ask(1e-3 * k, v, np.array([300.0, -40.0]))
        v = v + 1e-3 * np.array([0.0, -40.0])  # the first is held, the second moves as asked
    np.testing.assert_allclose(resistance.acceleration, [300.0, 0.0], rtol=1e-6, atol=1e-6)
    resistance.reset()
    resistance.observe(1.0, v)
    np.testing.assert_array_equal(resistance.acceleration, 0.0)


def test_no_time_passes_no_resistance_is_learned() -> None:
    resistance = Resistance(1)
    for _ in range(3):
        resistance.observe(0.5, np.ones(1))
        resistance.ask(0.5, np.ones(1), np.ones(1))
    np.testing.assert_array_equal(resistance.acceleration, 0.0)


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
