"""The torque laws: the plan's own torques, restoring errors, what is read and what is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from pivotgait.control import (
    AdmittanceController,
    Controller,
    FeedForwardController,
    HybridController,
    HybridGains,
    Measurement,
    PositionController,
    Reference,
    resolution,
)

Array = NDArray[np.float64]
Read = Callable[..., Measurement]
LAWS = (HybridController, FeedForwardController, PositionController, AdmittanceController)
RIGID = HybridGains(contact_stiffness=1e12)
"""z_d = 0: the planned tip just touches, so that the planned state has no error at all."""
TIMES = (0.0, 0.21, 0.45, 0.8, 1.15)


def planned_torque(reference: Reference, time: float) -> Array:
    """The plan's torque, straight between its samples."""
    phase = reference.phase_at(time)
    motion = phase.samples.robot
    assert motion is not None
    columns = motion.tau.T
    return np.array([np.interp(time - phase.start, phase.samples.time, c) for c in columns])


def acceleration(reference: Reference, measurement: Measurement, torque: Array) -> Array:
    """(n,) of the model without URDF damping, the planned forces acting on it."""
    robot, data = reference.robot, reference.robot.model.createData()
    wanted = reference.at(measurement.time)
    load = np.zeros(robot.nv)
    pin.computeJointJacobians(robot.model, data, measurement.q)
    phase = reference.phases[wanted.phase]
    for hold, in_tool in zip(phase.holds, wanted.force_in_tool, strict=True):
        frame, turn = hold.finger.tip_frame_id, wanted.tool.rotation
        pin.updateFramePlacement(robot.model, data, frame)
        jacobian = pin.getFrameJacobian(robot.model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        force, lever = turn @ in_tool, turn @ (hold.finger.tip_radius * hold.normal)
        load += jacobian.T @ np.concatenate((force, np.cross(lever, force)))
    driven = torque - load - robot.model.damping * wanted.v
    return np.asarray(pin.aba(robot.model, data, measurement.q, measurement.v, driven))


@pytest.mark.parametrize("time", TIMES)
def test_on_the_plan_the_torque_is_that_of_the_plan(
    reference: Reference, read: Read, time: float
) -> None:
    """Eq. (17): at the planned state, with the planned forces, tau is the plan's own."""
    law = HybridController(reference, RIGID)
    damping = reference.robot.model.damping * reference.at(time).v
    found = law.torque(read(time)) - damping
    np.testing.assert_allclose(found, planned_torque(reference, time), atol=5e-2)


@pytest.mark.parametrize("law", LAWS)
def test_contract(reference: Reference, read: Read, law: type[Controller]) -> None:
    """Finite torques, kept by the caller; two runs agree bit for bit after a reset."""
    controller = law(reference)  # type: ignore[call-arg]
    readings = [read(0.01 * k, off=1e-3, more=0.3) for k in range(0, 120, 7)]
    runs = []
    for _ in range(2):
        controller.reset()
        runs.append([controller.torque(reading) for reading in readings])
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.all(np.isfinite(runs[0]))
    assert np.shape(runs[0]) == (len(readings), reference.robot.nv)


@pytest.mark.parametrize("time", [0.3, 0.9])
@pytest.mark.parametrize("column", [0, 7, 11, 15])
def test_a_displaced_joint_is_driven_back(
    reference: Reference, read: Read, time: float, column: int
) -> None:
    """The work of the acceleration that the error adds is against the error, in task space."""
    law = FeedForwardController(reference)
    off = np.zeros(reference.robot.nv)
    off[column] = 1e-4
    plain, moved = read(time), read(time, off=off)
    a = acceleration(reference, moved, law.torque(moved))
    b = acceleration(reference, plain, law.torque(plain))
    task = law.tasks[reference.at(time).phase]
    added = task.matrix @ (a - b)
    error = task.matrix @ off
    assert added @ error < -0.5 * law.gains.position * error @ error


def test_more_force_than_planned_moves_the_tips_out(
    reference: Reference, read: Read, monkeypatch: pytest.MonkeyPatch
) -> None:
    """(14): a surplus of f_n is answered by f_n / k_m along the outward normal, and only there."""
    monkeypatch.setattr(resolution, "NEAR_SINGULAR", 0.0)
    law = HybridController(reference, RIGID)
    plain, pressed = read(0.3), read(0.3, more=0.02)
    change = acceleration(reference, pressed, law.torque(pressed))
    change -= acceleration(reference, plain, law.torque(plain))
    task = law.tasks[0]
    wanted = np.zeros(reference.robot.nv)
    wanted[task.z_rows] = -0.02 / law.gains.impedance_mass
    np.testing.assert_allclose(task.matrix @ change, wanted, atol=1e-5)


def test_tangential_readings_change_nothing(reference: Reference, read: Read) -> None:
    law = HybridController(reference)
    plain = read(0.3)
    turn = plain.tool_rotation
    sideways = {
        hold.finger.name: plain.force[hold.finger.name] + turn @ hold.toolRtarget[:, 0]
        for hold in reference.phases[0].holds
    }
    other = plain._replace(force=sideways)
    np.testing.assert_allclose(law.torque(other), law.torque(plain), atol=1e-9)


def test_the_feed_forward_baseline_reads_no_forces(reference: Reference, read: Read) -> None:
    law = FeedForwardController(reference)
    np.testing.assert_array_equal(
        law.torque(read(0.3, more=1.0)), law.torque(read(0.3)._replace(force={}))
    )


def test_an_idle_finger_is_driven_by_its_joints_alone(reference: Reference, read: Read) -> None:
    """Middle finger in the air: its error is answered by K_p, and moves no holding tip."""
    law = HybridController(reference)
    column = reference.robot.fingers["middle"].columns[1]
    off = np.zeros(reference.robot.nv)
    off[column] = 1e-3
    moved, plain = read(0.9, off=off), read(0.9)
    change = acceleration(reference, moved, law.torque(moved))
    change -= acceleration(reference, plain, law.torque(plain))
    assert change[column] == pytest.approx(-law.gains.position * 1e-3, rel=1e-6)
    others = np.delete(change, column)
    assert np.max(np.abs(others)) < 1e-6


def test_forces_turn_with_the_measured_tool(reference: Reference, read: Read) -> None:
    """Spun about a finger's normal, the tool takes only the tangential part along."""
    law = HybridController(reference)
    plain = read(0.3)
    turned = plain._replace(tool_rotation=pin.exp3(np.array([0.0, 0.0, 0.05])) @ np.eye(3))
    turned = turned._replace(tool_rotation=turned.tool_rotation @ plain.tool_rotation)
    assert np.max(np.abs(law.torque(turned) - law.torque(plain))) > 1e-4


@pytest.mark.parametrize("extra", [0.5, -0.5])
def test_admittance_gives_way(reference: Reference, read: Read, extra: float) -> None:
    """A lasting surplus of force moves the commanded tips outwards, more and more."""
    law = AdmittanceController(reference)
    moved = []
    for _ in range(3):
        for _ in range(50):
            law.torque(read(0.3, more=extra))
        moved.append(law.commanded_normals)
    assert np.all(np.sign(moved) == -np.sign(extra))
    assert np.all(np.abs(np.diff(moved, axis=0)) > 0.0)
    assert np.all(np.abs(np.diff(moved, axis=0)[1]) > 0.0)


def test_a_servo_at_rest_is_as_stiff_as_it_says(reference: Reference, read: Read) -> None:
    """Tips held by their contacts, nothing moves: tau = N + K (q_c - q)."""
    law = PositionController(reference, tip_stiffness=5e3)
    wanted = reference.at(0.0)
    free = law.servo.torque(wanted.q, 0 * wanted.q, wanted.q, 0 * wanted.q, np.zeros((0, 19)))
    bias = pin.rnea(
        reference.robot.model,
        reference.robot.model.createData(),
        wanted.q,
        0 * wanted.q,
        0 * wanted.q,
    )
    np.testing.assert_allclose(free, bias, atol=1e-9)
    held = np.eye(reference.robot.nv)
    off = 1e-3 * np.ones(reference.robot.nv)
    pressed = law.servo.torque(wanted.q - off, 0 * off, wanted.q, 0 * off, held)
    bias = pin.rnea(
        reference.robot.model, reference.robot.model.createData(), wanted.q - off, 0 * off, 0 * off
    )
    np.testing.assert_allclose(pressed - bias, law.servo.stiffness * off, rtol=0.02)


def test_phases_without_holds_are_followed(plan, read: Read) -> None:
    """An arm-hand that touches nothing is a robot all the same."""
    phase = replace(plan.phases[1], contacts={})
    reference = Reference.of(replace(plan, phases=(phase,)))
    law = HybridController(reference)
    wanted = reference.at(0.2)
    reading = read(0.0)._replace(time=0.2, q=wanted.q, v=wanted.v, force={})
    a = acceleration(reference, reading, law.torque(reading))
    np.testing.assert_allclose(a, wanted.a, atol=2e-2)
