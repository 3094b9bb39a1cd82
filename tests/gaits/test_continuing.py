"""The rest of a gait from a measured state: the old rest from the planned one, joined, refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.gaits import Continuation, MeasuredState, continue_gait, plan_gait
from pivotgait.models import Scene, load_scene
from pivotgait.plans import GaitPlan

DONE = 3  # after the knife's first addition


@cache
def scene() -> Scene:
    return load_scene("knife")


@cache
def rest() -> GaitPlan:
    plan = plan_gait(scene())
    return replace(plan, phases=plan.phases[DONE:])


def planned_state() -> MeasuredState:
    first = rest().phases[0]
    assert first.robot is not None
    turn = first.tool.rotation[0].as_matrix()
    return MeasuredState(first.robot.q[0], first.tool.position[0], turn)


def going_on(measured: MeasuredState, plan: GaitPlan | None = None) -> Continuation:
    return continue_gait(plan or rest(), scene(), scene().gaits["default"], measured)


def moved_state(angle: float, shift: float) -> MeasuredState:
    """The tool turned and shifted, the hand where it was planned to be."""
    turn = Rotation.from_rotvec([0.3 * angle, -0.5 * angle, angle]).as_matrix()
    state = planned_state()
    return replace(
        state,
        tool_position=state.tool_position + np.array([shift, -shift, 0.0]),
        tool_rotation=turn @ state.tool_rotation,
    )


def test_from_the_planned_state_the_rest_is_the_old_rest() -> None:
    found = going_on(planned_state())
    assert found.correction.pivot_m < 1e-9
    assert found.correction.turn_rad < 1e-9
    assert max(found.correction.contacts_m.values()) < 1e-9
    for new, old in zip(found.plan.phases, rest().phases, strict=True):
        assert (new.name, new.kind, new.finger) == (old.name, old.kind, old.finger)
        assert new.robot is not None
        assert old.robot is not None
        np.testing.assert_allclose(new.robot.q[[0, -1]], old.robot.q[[0, -1]], atol=1e-6)
        for name, track in new.contacts.items():
            np.testing.assert_allclose(track.point, old.contacts[name].point, atol=1e-9)
            ends = old.contacts[name].force[[0, -1]]
            np.testing.assert_allclose(track.force[[0, -1]], ends, atol=1e-3)
        turned = new.tool.rotation[-1].inv() * old.tool.rotation[-1]
        assert turned.magnitude() < 1e-5


@pytest.mark.parametrize(("angle", "shift"), [(2e-3, 0.0), (0.0, 4e-4), (-2e-3, 3e-4)])
def test_the_rest_starts_from_the_measured_tool_and_fingers_and_its_phases_join(
    angle: float, shift: float
) -> None:
    measured = moved_state(angle, shift)
    found = going_on(measured)
    first, robot = found.plan.phases[0], scene().robot
    assert robot is not None
    turn = first.tool.rotation[0].as_matrix()
    np.testing.assert_allclose(turn, measured.tool_rotation, atol=1e-9)
    tip = measured.tool_position + turn @ scene().tool.pivot_in_tool
    planned_tip = first.tool.position[0] + turn @ scene().tool.pivot_in_tool
    np.testing.assert_allclose(planned_tip[:2], tip[:2], atol=1e-9)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, measured.q)
    for name, track in first.contacts.items():
        if track.is_pivot:
            continue
        finger = robot.fingers[name]
        at = pin.updateFramePlacement(robot.model, data, finger.tip_frame_id).translation
        way = turn.T @ (at - first.tool.position[0]) + finger.tip_radius * track.normal
        off = way - track.point
        np.testing.assert_allclose(off - (off @ track.normal) * track.normal, 0.0, atol=1e-9)
    for one, other in pairwise(found.plan.phases):
        assert one.robot is not None
        assert other.robot is not None
        np.testing.assert_allclose(one.robot.q[-1], other.robot.q[0], atol=1e-8)
        np.testing.assert_allclose(one.tool.orientation[-1], other.tool.orientation[0], atol=1e-9)
        for name in one.contacts.keys() & other.contacts.keys():
            ends = one.contacts[name].force[-1], other.contacts[name].force[0]
            np.testing.assert_allclose(*ends, atol=1e-6)


def test_the_correction_tells_how_far_the_tip_and_the_tool_have_moved() -> None:
    found = going_on(moved_state(0.0, 3e-4)).correction
    assert found.pivot_m == pytest.approx(3e-4 * np.sqrt(2.0), abs=1e-9)
    assert found.turn_rad < 1e-9
    assert going_on(moved_state(2e-3, 0.0)).correction.turn_rad == pytest.approx(
        2e-3 * np.linalg.norm([0.3, 0.5, 1.0])
    )


def broken(**changes: object) -> MeasuredState:
    return replace(planned_state(), **changes)


@pytest.mark.parametrize(
    "change",
    [
        {"q": np.zeros(3)},
        {"tool_position": np.array([0.0, np.nan, 0.0])},
        {"tool_rotation": 1.01 * np.eye(3)},
        {"tool_rotation": np.eye(2)},
    ],
)
def test_a_state_that_is_none_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(InputError, match="measured state"):
        going_on(broken(**change))


@pytest.mark.parametrize("done", [1, 2])
def test_a_gait_goes_on_only_where_every_finger_rests_on_the_tool(done: int) -> None:
    plan = replace(rest(), phases=rest().phases[done:])
    with pytest.raises(InputError, match="addition"):
        going_on(planned_state(), plan)


def test_phases_that_are_not_the_last_ones_are_refused() -> None:
    plan = replace(rest(), phases=rest().phases[:1])
    with pytest.raises(InputError, match="not the last"):
        going_on(planned_state(), plan)
