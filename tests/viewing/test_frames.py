"""Frames lie on the plan's motion: even in time, exact where the plan has a sample."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.plotting.posture import skeleton
from pivotgait.plotting.timeline import spans
from pivotgait.viewing import frames


def rotations(body):
    return Rotation.from_quat(body.wxyz, scalar_first=True)


@pytest.mark.parametrize("rate", [5.0, 30.0, 200.0])
def test_frames_are_even_and_span_the_gait(plan, rate):
    found = frames(plan, rate)
    total = spans(plan)[-1].end
    assert found.time[0] == 0.0
    assert found.time[-1] == pytest.approx(total)
    steps = np.diff(found.time)
    np.testing.assert_allclose(steps, steps[0])
    assert steps[0] <= 1.0 / rate + 1e-12
    assert len(found) == len(found.phase) == len(found.tool.position)


def test_phases_come_in_order_and_none_is_left_out(plan):
    found = frames(plan, 30.0)
    assert np.all(np.diff(found.phase) >= 0)
    assert set(found.phase) == set(range(len(plan.phases)))
    for span, number in zip(spans(plan), range(len(plan.phases)), strict=True):
        inside = found.time[found.phase == number]
        assert span.start - 1e-12 <= inside.min()
        assert inside.max() <= span.end + 1e-12


def test_the_pivot_stays_on_the_table(plan):
    """The tool turns about it, so that a dense plan's frames keep it within a hair."""
    found = frames(plan, 60.0)
    pivot = found.tool.position + rotations(found.tool).as_matrix() @ plan.tool.pivot_in_tool
    np.testing.assert_allclose(pivot, np.broadcast_to(pivot[0], pivot.shape), atol=2e-5)


def test_a_frame_on_a_sample_is_the_sample(plan):
    lift = plan.phases[0]
    found = frames(replace(plan, phases=(lift,)), 40.0)  # 32 steps of 25 ms
    np.testing.assert_allclose(found.tool.position, lift.tool.position, atol=1e-12)
    apart = (rotations(found.tool) * lift.tool.rotation.inv()).magnitude()
    np.testing.assert_allclose(apart, 0.0, atol=1e-7)
    for contact in found.contacts:
        track = lift.contacts[contact.track.name]
        np.testing.assert_allclose(contact.force, track.force, atol=1e-12)
        np.testing.assert_allclose(contact.point, track.world_point(lift.tool), atol=1e-12)


def test_a_contact_exists_in_its_phases_only(plan):
    found = frames(plan, 30.0)
    (middle,) = (each for each in found.contacts if each.track.name == "middle")
    there = np.isfinite(middle.point).all(axis=1)
    np.testing.assert_array_equal(there, found.phase >= 2)
    assert not middle.force[~there].any()


def test_a_finger_that_comes_back_elsewhere_is_another_contact(plan):
    moved = plan.phases[-1]
    index = replace(moved.contacts["index"], point=moved.contacts["index"].point + 0.01)
    moved = replace(moved, contacts={**moved.contacts, "index": index})
    found = frames(replace(plan, phases=(*plan.phases[:-1], moved)), 30.0)
    places = [each for each in found.contacts if each.track.name == "index"]
    assert len(places) == 2
    there = [np.isfinite(each.point[:, 0]) for each in places]
    assert not np.any(there[0] & there[1])


def test_links_are_the_kinematics_of_the_joints(robot_plan):
    lift = robot_plan.phases[0]
    found = frames(replace(robot_plan, phases=(lift,)), 40.0)
    poses = skeleton(robot_plan.robot).poses(lift.robot.q)
    assert set(found.links) == set(poses)
    for name, pose in poses.items():
        np.testing.assert_allclose(found.links[name].position, pose[:, :3, 3], atol=1e-9)
        turn = rotations(found.links[name]).as_matrix()
        np.testing.assert_allclose(turn, pose[:, :3, :3], atol=1e-9)


def test_a_plan_without_a_robot_has_no_links(plan):
    found = frames(plan)
    assert not found.links
    assert found.skeleton is None


@pytest.mark.parametrize("rate", [0.0, -3.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused(plan, rate):
    with pytest.raises(InputError, match="rate"):
        frames(plan, rate)


def test_a_phase_that_lacks_the_robots_motion_is_named(robot_plan, plan):
    phases = (*robot_plan.phases[:1], *plan.phases[1:])
    with pytest.raises(InputError, match="01_relocation"):
        frames(replace(robot_plan, phases=phases))
