"""Robot, tool and table as one Pinocchio model, so that a single call places every shape."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from pivotgait.exceptions import InputError
from pivotgait.models.coal_shapes import coal_geometry
from pivotgait.models.robot import Robot
from pivotgait.models.tool import Tool

TABLE = "table"
TOOL = "tool"


@dataclass(frozen=True, eq=False)
class Bodies:
    """Everything that may collide.

    Attributes:
        model: ``pinocchio.Model`` of the robot's joints in their order, then a free-flyer of the
            tool frame: q is (nv + 7,), the tool's position [m] and xyzw quaternion last.
        geometry: ``pinocchio.GeometryModel`` of all shapes with the pairs that must not touch:
            the robot's own, robot and tool, robot and table. Links fixed to the world are not
            paired with the table they stand on, nor the tool, which touches it, with the table.
        names: of the shapes: their link, ``tool.<shape>`` or ``table``.
        tips: places of each finger's tip shapes.
        tool_shapes: places of the tool's shapes.
    """

    model: Any
    geometry: Any
    names: tuple[str, ...]
    tips: Mapping[str, tuple[int, ...]]
    tool_shapes: tuple[int, ...]


def build_bodies(robot: Robot, tool: Tool, table_height: float) -> Bodies:
    """Join robot, tool and table.

    Args:
        robot: whose root is the world.
        tool: free to be placed anywhere.
        table_height: of the table's plane [m]; all below it is table.

    Raises:
        InputError: for a height that is not finite.
    """
    if not np.isfinite(table_height):
        raise InputError(f"table height {table_height} is not finite", mend="give it in metres")
    model, geometry = pin.Model(robot.model), pin.GeometryModel(robot.collision)
    names = [model.frames[each.parentFrame].name for each in geometry.geometryObjects]
    links = range(len(names))
    moving = [k for k in links if geometry.geometryObjects[k].parentJoint > 0]
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "free_tool")
    tool_shapes = []
    for shape in tool.shapes:
        name = f"{TOOL}.{shape.name}"
        pose = pin.SE3(np.array(shape.rotation), np.array(shape.translation))
        placed = pin.GeometryObject(name, joint, 0, pose, coal_geometry(shape))
        tool_shapes.append(geometry.addGeometryObject(placed))
        names.append(name)
    ground = coal.Halfspace(np.array([0.0, 0.0, 1.0]), float(table_height))
    table = geometry.addGeometryObject(pin.GeometryObject(TABLE, 0, 0, pin.SE3.Identity(), ground))
    names.append(TABLE)
    for link in links:
        for shape in tool_shapes:
            geometry.addCollisionPair(pin.CollisionPair(link, shape))
    for link in moving:
        geometry.addCollisionPair(pin.CollisionPair(link, table))
    tips = {
        finger.name: tuple(k for k in links if names[k] == finger.tip_frame)
        for finger in robot.fingers.values()
    }
    return Bodies(model, geometry, tuple(names), MappingProxyType(tips), tuple(tool_shapes))


def without_pairs(geometry: Any, left_out: Iterable[tuple[int, int]]) -> Any:
    """A copy of a ``pinocchio.GeometryModel`` that shares its shapes but not some pairs."""
    copy = pin.GeometryModel(geometry)
    for first, second in left_out:
        copy.removeCollisionPair(pin.CollisionPair(first, second))
    return copy
