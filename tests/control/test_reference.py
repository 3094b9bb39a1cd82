"""The reference passes the plan's samples, and its rates are its derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.control import Reference
from pivotgait.exceptions import InputError
from pivotgait.kinematics import ClosedChain
from pivotgait.plans import GaitPlan

TIMES = (0.013, 0.31, 0.555, 0.72, 1.1)


@pytest.mark.parametrize("index", [0, 1])
def test_passes_the_samples(reference: Reference, index: int) -> None:
    phase = reference.phases[index]
    tool, motion = phase.samples.tool, phase.samples.robot
    turns = tool.rotation.as_matrix()
    assert motion is not None
    for k, time in enumerate(phase.samples.time):
        wanted = phase.at(float(time))
        np.testing.assert_allclose(wanted.q, motion.q[k], atol=1e-12)
        np.testing.assert_allclose(wanted.v, motion.v[k], atol=1e-4)
        np.testing.assert_allclose(wanted.a, motion.a[k], atol=2e-2)
        np.testing.assert_allclose(wanted.tool.position, tool.position[k], atol=1e-12)
        np.testing.assert_allclose(wanted.tool.rotation, turns[k], atol=1e-12)
        np.testing.assert_allclose(
            wanted.tool.angular_velocity, tool.angular_velocity[k], atol=1e-5
        )
        for hold, force in zip(phase.holds, wanted.force_in_tool, strict=True):
            planned = phase.samples.contacts[hold.finger.name].force[k]
            np.testing.assert_allclose(wanted.tool.rotation @ force, planned, atol=1e-12)


@pytest.mark.parametrize("time", TIMES)
def test_rates_are_derivatives(reference: Reference, rate, time: float) -> None:
    wanted = reference.at(time)
    np.testing.assert_allclose(wanted.v, rate(lambda t: reference.at(t).q, time), atol=1e-8)
    np.testing.assert_allclose(wanted.a, rate(lambda t: reference.at(t).v, time), atol=1e-6)
    tool = wanted.tool
    for name, rate_name in (
        ("position", "linear_velocity"),
        ("linear_velocity", "linear_acceleration"),
        ("angular_velocity", "angular_acceleration"),
    ):
        found = rate(lambda t, name=name: getattr(reference.at(t).tool, name), time)
        np.testing.assert_allclose(getattr(tool, rate_name), found, atol=1e-6)


@pytest.mark.parametrize("time", TIMES)
def test_orientation_turns_with_its_angular_velocity(
    reference: Reference, rate, time: float
) -> None:
    tool = reference.at(time).tool
    np.testing.assert_allclose(tool.rotation @ tool.rotation.T, np.eye(3), atol=1e-14)
    turning = rate(lambda t: reference.at(t).tool.rotation, time) @ tool.rotation.T
    np.testing.assert_allclose(pin.skew(tool.angular_velocity), turning, atol=1e-8)


@pytest.mark.parametrize("time", TIMES)
def test_holding_tips_stay_at_their_holds_between_samples(
    reference: Reference, time: float
) -> None:
    wanted = reference.at(time)
    chain = ClosedChain(reference.robot, reference.phases[wanted.phase].holds)
    chain.update(wanted.q, wanted.tool.rotation, wanted.tool.position)
    assert np.max(np.abs(chain.residual)) < 1e-6
    np.testing.assert_allclose(
        chain.jacobian @ wanted.v,
        chain.target_rate(wanted.tool.linear_velocity, wanted.tool.angular_velocity),
        atol=1e-4,
    )


def test_phases_join_and_the_end_lasts(reference: Reference) -> None:
    seam = reference.phases[1].start
    before, after = reference.at(seam - 1e-9), reference.at(seam)
    assert (before.phase, after.phase) == (0, 1)
    np.testing.assert_allclose(before.q, after.q, atol=1e-8)
    np.testing.assert_allclose(before.tool.rotation, after.tool.rotation, atol=1e-8)
    end, later = reference.at(reference.duration), reference.at(reference.duration + 5.0)
    np.testing.assert_array_equal(end.q, later.q)
    np.testing.assert_array_equal(later.v, 0.0 * later.v + end.v)
    early = reference.at(-1.0)
    np.testing.assert_array_equal(early.q, reference.at(0.0).q)


def test_the_moving_finger_of_a_relocation_does_not_hold(reference: Reference) -> None:
    names = [[hold.finger.name for hold in phase.holds] for phase in reference.phases]
    assert set(names[0]) == {"thumb", "index", "middle"}
    assert set(names[1]) == {"thumb", "index"}


def test_a_hold_lasts_over_phases(reference: Reference) -> None:
    first = {hold.finger.name: hold for hold in reference.phases[0].holds}
    assert all(first[hold.finger.name] is hold for hold in reference.phases[1].holds)


def test_quaternions_of_either_sign_give_the_same(plan: GaitPlan, reference: Reference) -> None:
    phase = plan.phases[0]
    quaternions = np.array(phase.tool.orientation)
    quaternions[::3] *= -1.0
    flipped = replace(phase, tool=replace(phase.tool, orientation=quaternions))
    other = Reference.of(replace(plan, phases=(flipped, *plan.phases[1:])), reference.robot)
    for time in TIMES[:3]:
        np.testing.assert_allclose(
            other.at(time).tool.rotation, reference.at(time).tool.rotation, atol=1e-14
        )


def without_motion(plan: GaitPlan) -> GaitPlan:
    return replace(plan, phases=(replace(plan.phases[0], robot=None), *plan.phases[1:]))


def other_joints(plan: GaitPlan) -> GaitPlan:
    assert plan.robot is not None
    names = ("elbow", *plan.robot.joint_names[1:])
    return replace(plan, robot=replace(plan.robot, joint_names=names))


def other_finger(plan: GaitPlan) -> GaitPlan:
    contacts = {
        f"{name}_x": replace(c, name=f"{name}_x") for name, c in plan.phases[0].contacts.items()
    }
    return replace(plan, phases=(replace(plan.phases[0], contacts=contacts), *plan.phases[1:]))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda plan: replace(plan, robot=None), "no arm-hand"),
        (without_motion, "no motion"),
        (other_joints, "joints differ"),
        (other_finger, "unknown finger"),
    ],
)
def test_unfit_plans_are_refused(plan: GaitPlan, change, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Reference.of(change(plan))
