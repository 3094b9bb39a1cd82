"""The hand follows the tool, from rest to rest, with the torques that mechanics asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InfeasibleError, SingularCoordinatesError
from pivotgait.frozen import Array
from pivotgait.kinematics import ClosedChain, rotation_from_angles
from pivotgait.phases.tracking import (
    Untracked,
    Waypoints,
    inverse_dynamics,
    track,
    with_torques,
)
from pivotgait.plans import ToolMotion
from tests.phases.hand_cases import led, phase, robot, tracked


def closed(k: int) -> ClosedChain:
    chain, tool = ClosedChain(robot(), led()[0]), phase().tool
    chain.update(tracked().q[k], tool.rotation[k].as_matrix(), tool.position[k])
    return chain


def test_fingertips_stay_at_their_contacts() -> None:
    """By forward kinematics alone: place of the tips, and the direction they see the contact in."""
    holds, tool = led()[0], phase().tool
    turn, data = tool.rotation.as_matrix(), robot().model.createData()
    for k, q in enumerate(tracked().q):
        pin.framesForwardKinematics(robot().model, data, q)
        for hold in holds:
            tip = data.oMf[hold.finger.tip_frame_id]
            centre = tool.position[k] + turn[k] @ hold.centre
            np.testing.assert_allclose(tip.translation, centre, atol=1e-9)
            seen = tip.rotation.T @ turn[k] @ hold.normal
            np.testing.assert_allclose(seen, hold.axis_in_tip, atol=1e-8)


def test_speeds_and_accelerations_keep_the_chain_closed() -> None:
    motion, tool = tracked(), phase().tool
    for k in range(len(motion.q)):
        chain = closed(k)
        assert np.abs(chain.residual).max() < 1e-8  # rows in radians over tips of 6 mm
        assert np.linalg.norm(chain.residual * chain.row_lengths()) < 1e-9
        moving = tool.linear_velocity[k], tool.angular_velocity[k]
        growing = tool.linear_acceleration[k], tool.angular_acceleration[k]
        rate, bias = chain.target_rate(*moving), chain.bias(motion.v[k], *moving, *growing)
        np.testing.assert_allclose(chain.jacobian @ motion.v[k], rate, atol=1e-10)
        np.testing.assert_allclose(chain.jacobian @ motion.a[k], bias, atol=1e-9)


def test_from_rest_to_rest_through_the_waypoints() -> None:
    motion, through = tracked(), led()[1]
    for array in (motion.v, motion.a):
        np.testing.assert_allclose(array[[0, -1]], 0.0, atol=1e-9)
    at = through.samples.astype(int)
    # waypoints are closed to 1e-11 m as the samples are
    np.testing.assert_allclose(motion.q[at], through.q, atol=1e-8)
    assert np.abs(motion.q[0] - motion.q[-1]).max() > 0.01


def test_samples_speeds_and_accelerations_tell_one_story() -> None:
    motion, time = tracked(), phase().time
    speed = np.gradient(motion.q, time, axis=0, edge_order=2)
    growth = np.gradient(motion.v, time, axis=0, edge_order=2)
    # central differences at 20 ms of a motion of 1.5 s
    np.testing.assert_allclose(motion.v, speed, atol=0.02 * np.abs(motion.v).max())
    np.testing.assert_allclose(motion.a, growth, atol=0.05 * np.abs(motion.a).max())


def test_a_phase_of_one_posture_is_still() -> None:
    holds, through = led()
    alone = Waypoints(np.zeros(1), through.q[:1])
    motion = track(robot(), holds, phase().time, phase().tool, alone)
    np.testing.assert_array_equal(motion.q, np.tile(through.q[0], (len(phase().time), 1)))
    assert not motion.v.any()
    assert not motion.a.any()


def shifted(by: Array) -> ToolMotion:
    return replace(phase().tool, position=phase().tool.position + by)


@pytest.mark.parametrize(
    ("far", "first", "last"), [(np.ones(76), 0, 0), (np.linspace(0.0, 1.0, 76), 10, 70)]
)
def test_a_tool_out_of_reach(far: Array, first: int, last: int) -> None:
    holds, through = led()
    away = shifted(np.outer(far, [0.0, 3.0, 0.0]))
    with pytest.raises(Untracked, match="cannot follow the tool at") as caught:
        track(robot(), holds, phase().time, away, through)
    assert isinstance(caught.value, InfeasibleError)
    assert first <= caught.value.sample <= last
    assert f"{phase().time[caught.value.sample]:.2f} s" in caught.value.what
    assert caught.value.q.shape == (robot().nv,)
    assert np.isfinite(caught.value.q).all()
    assert caught.value.mend


def test_a_tool_turned_to_where_local_coordinates_are_singular() -> None:
    """Where a tip's angle psi is 90 degrees: no error of coordinates, the hand cannot follow."""
    holds, through = led()
    data = robot().model.createData()
    pin.framesForwardKinematics(robot().model, data, through.q[0])
    contact = data.oMf[holds[0].finger.tip_frame_id].rotation @ holds[0].tipRcontact
    right_angle = rotation_from_angles(np.array([0.0, 0.5 * np.pi, 0.0]))
    turned = contact @ right_angle.T @ holds[0].toolRtarget.T
    orientation = np.tile(pin.Quaternion(turned).coeffs(), (len(phase().time), 1))
    with pytest.raises(Untracked) as caught:
        track(robot(), holds, phase().time, replace(phase().tool, orientation=orientation), through)
    assert isinstance(caught.value.__cause__, SingularCoordinatesError)
    assert caught.value.sample == 0
    np.testing.assert_allclose(caught.value.q, through.q[0], atol=1e-12)


def test_torques_are_those_of_bodies_pushed_at_their_contacts() -> None:
    """Eq. 17 against the recursive algorithm with the tool's reaction as external forces."""
    model, tool, motion = robot().model, phase().tool, tracked()
    found = with_torques(robot(), motion, phase().contacts, tool)
    for name in ("q", "v", "a"):
        np.testing.assert_array_equal(getattr(found, name), getattr(motion, name))
    points = {name: each.world_point(tool) for name, each in phase().contacts.items()}
    data = model.createData()
    for k, state in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        pin.forwardKinematics(model, data, state[0])
        outside = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
        for name in led_fingers():
            joint = model.frames[robot().fingers[name].tip_frame_id].parentJoint
            push = -phase().contacts[name].force[k]
            there = pin.Force(push, np.cross(points[name][k], push))  # about the world's origin
            outside[joint] += data.oMi[joint].actInv(there)
        np.testing.assert_allclose(found.tau[k], pin.rnea(model, data, *state, outside), atol=1e-8)


def led_fingers() -> tuple[str, ...]:
    return tuple(hold.finger.name for hold in led()[0])


def test_the_tool_s_share_of_the_power_is_that_of_its_forces() -> None:
    """tau . v less that of the free arm-hand = sum f . (speed of the contact point)."""
    tool, motion = phase().tool, tracked()
    pushed = with_torques(robot(), motion, phase().contacts, tool).tau
    power = np.sum((pushed - inverse_dynamics(robot(), motion)) * motion.v, axis=1)
    work = np.zeros(len(power))
    for name in led_fingers():
        track_of = phase().contacts[name]
        lever = track_of.world_point(tool) - tool.position
        speed = tool.linear_velocity + np.cross(tool.angular_velocity, lever)
        # Spin about the normal moves no point on it: the tip's surface moves with the tool.
        work += np.sum(track_of.force * speed, axis=1)
    assert np.abs(work).max() > 1e-2  # [W]
    np.testing.assert_allclose(power, work, atol=1e-8)


def test_torques_at_rest_hold_the_weight() -> None:
    still = track(
        robot(), led()[0], phase().time, phase().tool, Waypoints(np.zeros(1), led()[1].q[:1])
    )
    free = inverse_dynamics(robot(), still)
    data = robot().model.createData()
    weight = pin.computeGeneralizedGravity(robot().model, data, still.q[0])
    np.testing.assert_allclose(free, np.tile(weight, (len(free), 1)), atol=1e-12)
    assert np.abs(weight).max() > 1.0
