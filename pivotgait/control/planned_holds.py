"""The holds of a plan's phases, as its own joint positions show them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import UnknownNameError
from pivotgait.frozen import Array
from pivotgait.kinematics import Hold
from pivotgait.models import Robot
from pivotgait.plans import ContactTrack, GaitPlan, Phase


def planned_holds(plan: GaitPlan, robot: Robot) -> tuple[tuple[Hold, ...], ...]:
    """Holds of each phase, in the order of the robot's fingers.

    A finger that comes or goes by force holds during the whole phase; one that relocates does
    not. A hold lasts as long as the contact stays: its direction in the fingertip is that of
    its first phase's start.

    Args:
        plan: whose phases have robot motions.
        robot: of the plan.

    Raises:
        UnknownNameError: for a contact that is neither the pivot nor one of the robot's fingers.
    """
    data = robot.model.createData()
    found: list[tuple[Hold, ...]] = []
    lasting: dict[str, Hold] = {}
    for phase in plan.phases:
        names = holding_fingers(phase, robot)
        lasting = {
            name: _lasting(lasting.get(name), phase.contacts[name])
            or _hold(robot, data, phase, phase.contacts[name])
            for name in names
        }
        found.append(tuple(lasting.values()))
    return tuple(found)


def holding_fingers(phase: Phase, robot: Robot) -> tuple[str, ...]:
    """Names of the fingers that touch the tool during a whole phase.

    Raises:
        UnknownNameError: for a contact that is neither the pivot nor one of the robot's fingers.
    """
    for name, contact in phase.contacts.items():
        if not contact.is_pivot and name not in robot.fingers:
            raise UnknownNameError("finger", name, robot.fingers, where=f"phase {phase.name}")
    moving = phase.finger if phase.kind == "relocation" else ""
    return tuple(name for name in robot.fingers if name in phase.contacts and name != moving)


def _lasting(hold: Hold | None, contact: ContactTrack) -> Hold | None:
    """The hold, if it is still at this contact."""
    if hold is None:
        return None
    centre = contact.point - hold.finger.tip_radius * contact.normal
    return hold if np.allclose(hold.centre, centre, rtol=0.0, atol=1e-9) else None


def _hold(robot: Robot, data: pin.Data, phase: Phase, contact: ContactTrack) -> Hold:
    finger = robot.fingers[contact.name]
    oRtip = _tip_rotation(robot, data, phase, finger.tip_frame_id)
    inward = phase.tool.rotation[0].as_matrix() @ contact.normal
    return Hold.of(finger, contact.point, contact.normal, oRtip.T @ inward)


def _tip_rotation(robot: Robot, data: pin.Data, phase: Phase, frame: int) -> Array:
    assert phase.robot is not None
    pin.forwardKinematics(robot.model, data, phase.robot.q[0])
    return np.array(pin.updateFramePlacement(robot.model, data, frame).rotation)
