"""Rows of the task: the kinematics' own coordinates, and their derivatives along a motion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from pivotgait.control import Reference
from pivotgait.control.frame_bundle import FrameBundle, FrameOnTool
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.tool_state import ToolState
from pivotgait.kinematics import FrameCoordinates, RigidMotion

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def bundle(reference: Reference) -> FrameBundle:
    model = reference.robot.model
    frames = [FrameOnTool.of_hold(hold) for hold in reference.phases[0].holds]
    return FrameBundle(model, model.createData(), frames)


def update(reference: Reference, frames: FrameBundle, q: Array, v: Array, tool: ToolState) -> None:
    data = frames._data
    pin.computeJointJacobians(reference.robot.model, data, q)
    pin.forwardKinematics(reference.robot.model, data, q, v, np.zeros_like(v))
    frames.update(v, tool)


@pytest.mark.parametrize("seed", range(3))
def test_frames_agree_with_those_of_the_planner(
    reference: Reference, bundle: FrameBundle, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    robot, wanted = reference.robot, reference.at(0.3)
    q, v = wanted.q + 0.1 * rng.normal(size=robot.nv), rng.normal(size=robot.nv)
    tool = wanted.tool._replace(
        angular_velocity=rng.normal(size=3),
        angular_acceleration=rng.normal(size=3),
        linear_acceleration=rng.normal(size=3),
    )
    update(reference, bundle, q, v, tool)
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    pin.forwardKinematics(robot.model, data, q, v, np.zeros(robot.nv))
    motion = RigidMotion(*tool[2:])
    for k, hold in enumerate(reference.phases[0].holds):
        other = FrameCoordinates.of_hold(robot.model, data, hold)
        other.refresh(tool.rotation, tool.position)
        np.testing.assert_allclose(bundle.value[k], other.value, atol=1e-13)
        np.testing.assert_allclose(bundle.jacobian[k], other.jacobian, atol=1e-12)
        rate = other.jacobian @ v - other.target_rate(motion)
        np.testing.assert_allclose(bundle.rate[k], rate, atol=1e-12)
        np.testing.assert_allclose(bundle.drift[k], other.drift(v, motion), atol=1e-11)


@pytest.mark.parametrize("time", [0.2, 0.8])
def test_errors_change_as_their_rates_say(
    reference: Reference, rate: Callable[..., Array], time: float
) -> None:
    """Joints leave the plan with steady acceleration: all of eq. (15) against differences."""
    rng = np.random.default_rng(1)
    robot = reference.robot
    phase = reference.phase_at(time)
    data = robot.model.createData()
    task = PhaseTask(robot, data, phase)
    start = reference.at(time)
    q, v, a = start.q + 0.02 * rng.normal(size=robot.nv), *rng.normal(size=(2, robot.nv))

    def at(t: float) -> PhaseTask:
        s = t - time
        now_q, now_v = q + s * v + 0.5 * s * s * a, v + s * a
        pin.computeJointJacobians(robot.model, data, now_q)
        pin.forwardKinematics(robot.model, data, now_q, now_v, np.zeros(robot.nv))
        task.update(now_q, now_v, reference.at(t))
        return task

    rates = rate(lambda t: at(t).error.copy(), time)
    second = rate(lambda t: at(t).rate_error.copy(), time)
    now = at(time)
    np.testing.assert_allclose(now.rate_error, rates, atol=1e-6)
    np.testing.assert_allclose(now.feed_forward - now.matrix @ a, second, atol=1e-5)


@pytest.mark.parametrize("index", [0, 1])
def test_the_plan_itself_has_no_error(reference: Reference, index: int) -> None:
    phase, robot = reference.phases[index], reference.robot
    data = robot.model.createData()
    task = PhaseTask(robot, data, phase)
    wanted = phase.at(0.25)
    pin.computeJointJacobians(robot.model, data, wanted.q)
    pin.forwardKinematics(robot.model, data, wanted.q, wanted.v, np.zeros(robot.nv))
    task.update(wanted.q, wanted.v, wanted)
    assert np.max(np.abs(task.error)) < 1e-6
    assert np.max(np.abs(task.rate_error)) < 1e-4
    np.testing.assert_allclose(task.feed_forward, task.matrix @ wanted.a, atol=5e-2)


def test_spin_about_a_normal_is_free(reference: Reference, bundle: FrameBundle) -> None:
    """theta is no row: a tip that spins about its normal has no error."""
    wanted = reference.at(0.3)
    hold = reference.phases[0].holds[0]
    turned = FrameOnTool(
        hold.finger.tip_frame_id,
        hold.tipRcontact @ pin.exp3(np.array([0.0, 0.0, 0.7])),
        hold.toolRtarget,
        hold.centre,
    )
    model = reference.robot.model
    spun = FrameBundle(model, model.createData(), [turned])
    for frames in (bundle, spun):
        update(reference, frames, wanted.q, wanted.v, wanted.tool)
    difference = spun.value[0] - bundle.value[0]
    assert abs(np.angle(np.exp(1j * (difference[0] - 0.7)))) < 1e-12
    np.testing.assert_allclose(difference[1:], 0.0, atol=1e-12)
