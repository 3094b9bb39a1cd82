"""How far a change of joint positions can move any shape relative to any other."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.frozen import Array, frozen
from pivotgait.models.robot import Robot
from pivotgait.planning.bodies import Bodies

SLIDE = 1.0
"""Every point of a link moves as far as the prismatic joint before it."""


def joint_reach(robot: Robot, bodies: Bodies) -> Array:
    """(nv,) farthest distance of a shape's point from each revolute joint's axis, or 1 [m].

    The sum of the lengths along the chain, which bounds the distance in every configuration.
    """
    model = bodies.model
    reach = np.zeros(model.njoints)
    for shape in bodies.geometry.geometryObjects:
        if not 0 < shape.parentJoint <= robot.nv:
            continue
        far = float(np.linalg.norm(shape.placement.translation)) + _radius(shape)
        joint = shape.parentJoint
        while joint > 0:
            reach[joint] = max(reach[joint], far)
            far += float(np.linalg.norm(model.jointPlacements[joint].translation))
            far += _stroke(robot, joint)
            joint = model.parents[joint]
    revolute = [not _stroke(robot, joint) for joint in range(1, robot.nv + 1)]
    return frozen(np.where(revolute, reach[1 : robot.nv + 1], SLIDE))


def motion_bounds(robot: Robot, bodies: Bodies) -> Array:
    """(B, nv) B such that max(B |dq|) bounds the relative motion of every two shapes [m].

    Rows: palm and one finger, against tool and table; and two fingers, against one another.
    Their joints are those between the two shapes, each of which moves them apart by no more
    than its reach times its change.
    """
    reach = joint_reach(robot, bodies)
    chains = [list(finger.columns) for finger in robot.fingers.values()]
    rows = [[*robot.palm_columns, *chain] for chain in chains]
    rows += [one + other for k, one in enumerate(chains) for other in chains[:k]]
    bounds = np.zeros((len(rows), robot.nv))
    for row, columns in zip(bounds, rows, strict=True):
        row[columns] = reach[columns]
    return frozen(bounds)


def tool_radius(bodies: Bodies) -> float:
    """Distance of the tool's farthest point from its centre of mass [m]."""
    shapes = [bodies.geometry.geometryObjects[k] for k in bodies.tool_shapes]
    return max(float(np.linalg.norm(s.placement.translation)) + _radius(s) for s in shapes)


def _radius(shape: Any) -> float:
    """Radius of a ball about a shape's origin that holds it [m]."""
    geometry = shape.geometry
    geometry.computeLocalAABB()
    return float(geometry.aabb_radius) + float(np.linalg.norm(geometry.aabb_center))


def _stroke(robot: Robot, joint: int) -> float:
    """Longest slide of a joint [m], 0 for a revolute one."""
    if joint > robot.nv or not _slides(robot, joint):
        return 0.0
    column = robot.model.joints[joint].idx_v
    return float(max(abs(robot.lower[column]), abs(robot.upper[column])))


def _slides(robot: Robot, joint: int) -> bool:
    return str(robot.model.joints[joint].shortname()).startswith("JointModelP")
