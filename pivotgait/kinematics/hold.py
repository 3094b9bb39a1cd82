"""A finger's hold: where its tip belongs on the tool, and which way it points there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pivotgait.contacts import contact_frame
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Finger, Robot


@dataclass(frozen=True, eq=False)
class Hold(FrozenArrays):
    """Contact frame C on the fingertip and target frame T on the tool (Xue et al., Section V).

    Both origins are the tip's centre, both z axes the tool's inward normal. While the finger
    holds, C stays at T up to spin about z.

    Attributes:
        finger: that holds.
        centre: (3,) origin of T: where the tip's centre should be, tool frame [m].
        toolRtarget: (3, 3) axes of T in the tool frame.
        tipRcontact: (3, 3) axes of C in the tip frame.
    """

    finger: Finger
    centre: Array
    toolRtarget: Array
    tipRcontact: Array

    @classmethod
    def of(cls, finger: Finger, point: Array, normal: Array, axis_in_tip: Array) -> Hold:
        """The hold at a contact; x axes by :func:`pivotgait.contacts.contact_frame`.

        Args:
            finger: that holds.
            point: (3,) contact on the tool's surface, tool frame [m].
            normal: (3,) unit inward normal there, tool frame.
            axis_in_tip: (3,) unit inward normal as the fingertip sees it, tip frame.

        Raises:
            InputError: for a point that is not finite or directions that are not unit vectors.
        """
        where = f"hold of {finger.name}"
        inward = _unit(normal, "normal", where)
        return cls(
            finger=finger,
            centre=_centre(finger, point, inward, where),
            toolRtarget=contact_frame(inward),
            tipRcontact=contact_frame(_unit(axis_in_tip, "axis_in_tip", where)),
        )

    @classmethod
    def at(
        cls,
        robot: Robot,
        q: Array,
        oRtool: Array,
        finger: Finger,
        point: Array,
        normal: Array,
    ) -> Hold:
        """The hold that keeps the fingertip's present orientation: all three angles are zero.

        Args:
            robot: to which the finger belongs.
            q: (nv,) configuration.
            oRtool: (3, 3) orientation of the tool, world <- tool.
            finger: that holds.
            point: (3,) contact on the tool's surface, tool frame [m].
            normal: (3,) unit inward normal there, tool frame.

        Raises:
            InputError: for a point that is not finite or a normal that is not a unit vector.
        """
        where = f"hold of {finger.name}"
        inward = _unit(normal, "normal", where)
        toolRtarget = contact_frame(inward)
        data = robot.model.createData()
        pin.forwardKinematics(robot.model, data, q)
        oRtip = pin.updateFramePlacement(robot.model, data, finger.tip_frame_id).rotation
        return cls(
            finger=finger,
            centre=_centre(finger, point, inward, where),
            toolRtarget=toolRtarget,
            tipRcontact=oRtip.T @ oRtool @ toolRtarget,
        )

    @property
    def normal(self) -> Array:
        """(3,) inward normal, tool frame."""
        return self.toolRtarget[:, 2]

    @property
    def axis_in_tip(self) -> Array:
        """(3,) inward normal as the fingertip sees it, tip frame."""
        return self.tipRcontact[:, 2]


def _centre(finger: Finger, point: Array, normal: Array, where: str) -> Array:
    if not np.all(np.isfinite(point)):
        raise InputError(f"point {point} is not finite", where=where, mend="give a contact point")
    return np.asarray(point - finger.tip_radius * normal)


def _unit(vector: Array, name: str, where: str) -> Array:
    v = np.asarray(vector, dtype=float)
    if v.shape != (3,) or not abs(np.linalg.norm(v) - 1.0) <= 1e-6:
        raise InputError(f"{name} {v} is not a unit vector", where=where, mend="normalise it")
    return np.asarray(v / np.linalg.norm(v))
