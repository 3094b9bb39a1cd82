"""How far the palm is from the handle's axis, by Coal."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.models import Robot, Tool

_THIN = 1e-4
"""Radius of the line that stands for the axis [m]; taken off the distance's error."""


class PalmDistance:
    """Distance between the palm link's shapes and the handle's axis, within the handle's ends.

    Args:
        robot: with collision shapes on its palm.
        tool: with a handle.

    Raises:
        InputError: for a palm without shapes.
    """

    def __init__(self, robot: Robot, tool: Tool) -> None:
        shapes = robot.collision.geometryObjects
        self._robot, self._data = robot, robot.model.createData()
        self._shapes = [each for each in shapes if each.parentFrame == robot.palm_frame_id]
        if not self._shapes:
            mend = "name a link with collision shapes"
            raise InputError("the palm has no shape", where="robot.palm", mend=mend)
        low, high = tool.handle.extent
        self._axis = coal.Capsule(_THIN, max(high - low, _THIN))
        self._middle = tool.handle.origin + 0.5 * (low + high) * tool.handle.axis
        self._turn = _z_to(tool.handle.axis)

    def __call__(self, q: Array, rotation: Array, position: Array) -> float:
        """Distance [m], 0 if the axis runs through the palm.

        Args:
            q: (nv,) joint positions.
            rotation: (3, 3) of the tool, world <- tool.
            position: (3,) of its centre of mass, world [m].

        Raises:
            InputError: for numbers that are not finite.
        """
        if not all(np.isfinite(each).all() for each in (q, rotation, position)):
            raise InputError("joint positions or tool pose not finite", mend="look for NaN")
        pin.forwardKinematics(self._robot.model, self._data, q)
        axis = _pose(rotation @ self._turn, position + rotation @ self._middle)
        nearest = min(self._distance(shape, axis) for shape in self._shapes)
        return max(nearest + _THIN, 0.0)

    def _distance(self, shape: Any, axis: Any) -> float:
        placed = self._data.oMi[shape.parentJoint] * shape.placement
        pose = _pose(placed.rotation, placed.translation)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        return float(coal.distance(shape.geometry, pose, self._axis, axis, request, result))


def _z_to(axis: Array) -> Array:
    """(3, 3) a rotation whose third column is ``axis``."""
    aside = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(aside, axis)
    first = first / np.linalg.norm(first)
    return np.column_stack((first, np.cross(axis, first), axis))


def _pose(rotation: Array, translation: Array) -> Any:
    return coal.Transform3s(np.array(rotation), np.array(translation))
