"""A hold puts the tip's sphere against the tool and its axis along the inward normal."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from pivotgait.exceptions import InputError
from pivotgait.kinematics import ClosedChain, Hold
from pivotgait.models import Robot

POINT, NORMAL, AXIS = np.array([0.1, 0.01, -0.02]), np.array([0.6, 0.0, -0.8]), np.eye(3)[1]


def test_centre_lies_a_radius_outside_the_surface(robot: Robot) -> None:
    thumb = robot.fingers["thumb"]
    hold = Hold.of(thumb, POINT, NORMAL, AXIS)
    np.testing.assert_allclose(POINT - hold.centre, thumb.tip_radius * NORMAL, atol=1e-16)
    np.testing.assert_allclose(hold.normal, NORMAL, atol=1e-16)
    np.testing.assert_allclose(hold.axis_in_tip, AXIS, atol=1e-16)
    for axes in (hold.toolRtarget, hold.tipRcontact):
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-15)
        assert np.linalg.det(axes) > 0.0


def test_hold_at_a_configuration_keeps_the_tips_orientation(grip: Any) -> None:
    q = grip.near()
    holds = [
        Hold.at(grip.robot, q, grip.oRtool, finger, POINT, NORMAL)
        for finger in grip.robot.fingers.values()
    ]
    chain = ClosedChain(grip.robot, holds)
    chain.update(q, grip.oRtool, grip.position)
    for finger in chain.fingers:
        np.testing.assert_allclose(finger.value[:3], 0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("point", "normal", "axis", "message"),
    [
        (POINT * np.nan, NORMAL, AXIS, "not finite"),
        (POINT, 2.0 * NORMAL, AXIS, "normal"),
        (POINT, NORMAL * np.nan, AXIS, "normal"),
        (POINT, NORMAL, np.zeros(3), "axis_in_tip"),
        (POINT, NORMAL[:2], AXIS, "normal"),
    ],
)
def test_bad_contacts_are_refused(
    robot: Robot, point: Any, normal: Any, axis: Any, message: str
) -> None:
    with pytest.raises(InputError, match=message) as error:
        Hold.of(robot.fingers["index"], point, normal, axis)
    assert "index" in str(error.value)


def test_hold_is_read_only(robot: Robot) -> None:
    hold = Hold.of(robot.fingers["index"], POINT, NORMAL, AXIS)
    with pytest.raises(ValueError, match="read-only"):
        hold.centre[0] = 1.0
    assert copy.copy(hold).finger is hold.finger
