"""Before a plan begins its fingers must close: a phase that does so, and where they start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin
from scipy.optimize import lsq_linear

from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.plans import ContactTrack, GaitPlan, Phase, RobotMotion, ToolMotion

GRASP = "grasp"
"""Name of the phase that closes the fingers."""
_STEPS = 40
_ITERATIONS = 50
_TOLERANCE_M = 1e-9
_DAMPING = 1e-6


def with_grasp(plan: GaitPlan, robot: Robot, duration_s: float) -> GaitPlan:
    """The plan with a phase before it in which the tool lies and the forces grow from zero.

    Forces and the torques they ask for grow as a straight line, so that they join those of the
    plan's first sample; everything else is that sample, at rest.

    Args:
        plan: with a robot.
        robot: of the plan.
        duration_s: of the phase [s].

    Raises:
        PlanFileError: for a plan without a robot.
    """
    first = plan.phases[0]
    if first.robot is None:
        raise PlanFileError("has no motion of a robot", where=first.name, mend="plan again")
    ramp = np.linspace(0.0, 1.0, _STEPS + 1)
    loads = _gravity_torque(plan, robot, first.robot.q[0])
    still = np.zeros((len(ramp), 3))
    tool = ToolMotion(
        position=_repeat(first.tool.position[0], ramp),
        orientation=_repeat(first.tool.orientation[0], ramp),
        linear_velocity=still,
        angular_velocity=still,
        linear_acceleration=still,
        angular_acceleration=still,
    )
    at_rest = np.zeros((len(ramp), robot.nv))
    motion = RobotMotion(
        q=_repeat(first.robot.q[0], ramp),
        v=at_rest,
        a=at_rest,
        tau=loads + ramp[:, None] * (first.robot.tau[0] - loads),
    )
    grasp = Phase(
        name=GRASP,
        kind="addition",
        finger="",
        time=duration_s * ramp,
        tool=tool,
        contacts={name: _growing(track, ramp) for name, track in first.contacts.items()},
        robot=motion,
    )
    return replace(plan, phases=(grasp, *plan.phases))


def standing_off(plan: GaitPlan, robot: Robot, distances: Mapping[str, float]) -> Array:
    """(nv,) joint positions of the plan's start, some fingertips off their contacts.

    Each finger's joints alone move its tip along the outward normal, by damped least squares.

    Args:
        plan: with a robot.
        robot: of the plan.
        distances: of the fingertips from their contacts [m], by finger.
    """
    first = plan.phases[0]
    assert first.robot is not None  # `with_grasp` refuses a plan without
    q = np.array(first.robot.q[0])
    data = robot.model.createData()
    turn = first.tool.rotation[0].as_matrix()
    for name, distance in distances.items():
        track, finger = first.contacts[name], robot.fingers[name]
        columns = list(finger.columns)
        goal = _tip(robot, data, finger.tip_frame_id, q) - distance * (turn @ track.normal)
        for _ in range(_ITERATIONS):
            error = goal - _tip(robot, data, finger.tip_frame_id, q)
            if np.linalg.norm(error) < _TOLERANCE_M:
                break
            jacobian = pin.computeFrameJacobian(
                robot.model,
                data,
                q,
                finger.tip_frame_id,
                pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
            )[:3, columns]
            q[columns] += _bounded_step(
                jacobian,
                error,
                robot.lower[columns] - q[columns],
                robot.upper[columns] - q[columns],
            )
    return np.asarray(np.clip(q, robot.lower, robot.upper))


def _bounded_step(jacobian: Array, error: Array, lower: Array, upper: Array) -> Array:
    """min |J dq - error|^2 + damping |dq|^2 within bounds: other joints do what one cannot."""
    joints = jacobian.shape[1]
    rows = np.vstack((jacobian, np.sqrt(_DAMPING) * np.eye(joints)))
    room = np.maximum(upper, 1e-9)
    step = lsq_linear(rows, np.append(error, np.zeros(joints)), (np.minimum(lower, -1e-9), room))
    return np.asarray(step.x)


def _tip(robot: Robot, data: pin.Data, frame: int, q: Array) -> Array:
    pin.forwardKinematics(robot.model, data, q)
    return np.array(pin.updateFramePlacement(robot.model, data, frame).translation)


def _gravity_torque(plan: GaitPlan, robot: Robot, q: Array) -> Array:
    model = robot.model.copy()
    model.gravity = pin.Motion(np.array(plan.gravity), np.zeros(3))
    return np.array(pin.computeGeneralizedGravity(model, model.createData(), np.array(q)))


def _growing(track: ContactTrack, ramp: Array) -> ContactTrack:
    return replace(track, force=ramp[:, None] * track.force[0], normal_min=0.0)


def _repeat(sample: Array, ramp: Array) -> Array:
    return np.tile(sample, (len(ramp), 1))
