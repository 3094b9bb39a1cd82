"""The arm-hand as its URDF text describes it, by Pinocchio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from pivotgait.certification.certificate import Finding
from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.urdf import UrdfSummary, check_urdf
from pivotgait.plans import PlannedRobot

WHERE = "robot of the plan"
_AT_ORIGIN = 1e-9


@dataclass(frozen=True, eq=False)
class RigidRobot(FrozenArrays):
    """What the URDF text says of the robot; every joint has one coordinate (nq = nv = n).

    Attributes:
        model: ``pinocchio.Model``.
        shapes: ``pinocchio.GeometryModel`` without pairs.
        joint_names: in the order of q.
        lower: (n,) joint limits [rad] or [m].
        upper: (n,) joint limits [rad] or [m].
        speed: (n,) joint speed limits [rad/s] or [m/s].
        effort: (n,) torque or force limits [N m] or [N].
        tip_frames: index of the tip frame by finger.
        tip_shapes: index in ``shapes`` of the sphere about each tip frame's origin, by finger;
            a finger without such a sphere is left out.
    """

    model: Any
    shapes: Any
    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    speed: Array
    effort: Array
    tip_frames: Mapping[str, int]
    tip_shapes: Mapping[str, int]


def rigid_robot(planned: PlannedRobot) -> RigidRobot:
    """Parse the robot's URDF text.

    Args:
        planned: the robot of a plan.

    Raises:
        UrdfError: if the text must not reach the native parsers.
        PlanFileError: if shapes are not primitive, joints are not those of the plan in its order,
            or a name in the plan is no link.
    """
    where = f"{WHERE}: urdf"
    summary = check_urdf(planned.urdf, where=where)
    _refuse_unfit(summary, planned, where)
    try:
        model = pin.buildModelFromXML(planned.urdf)
        shapes = pin.buildGeomFromUrdfString(model, planned.urdf, pin.GeometryType.COLLISION)
    except (RuntimeError, ValueError) as error:
        raise PlanFileError(f"Pinocchio: {error}", where=where, mend="mend the URDF") from error
    if shapes.ngeoms != len(summary.collisions):
        # Pinocchio drops what it cannot parse, and a shape that is gone collides with nothing.
        raise PlanFileError("Pinocchio dropped a shape", where=where, mend="mend the URDF")
    names = tuple(model.names[1:])
    if names != planned.joint_names or model.nq != model.nv or model.nv != len(names):
        raise PlanFileError(
            "joint_names are not the URDF's joints in Pinocchio's order",
            where=WHERE,
            mend=f"use {', '.join(names)}"[:200],
        )
    frames = {
        name: int(model.getFrameId(finger.tip_frame, pin.FrameType.BODY))
        for name, finger in planned.fingers.items()
    }
    tips = {name: _sphere_at(model, shapes, frame) for name, frame in frames.items()}
    return RigidRobot(
        model=model,
        shapes=shapes,
        joint_names=names,
        lower=np.array(model.lowerPositionLimit),
        upper=np.array(model.upperPositionLimit),
        speed=np.array(model.upperVelocityLimit),
        effort=np.array(model.upperEffortLimit),
        tip_frames=frames,
        tip_shapes={name: shape for name, shape in tips.items() if shape is not None},
    )


def check_tip_radii(planned: PlannedRobot, rigid: RigidRobot) -> list[Finding]:
    """Each fingertip is a sphere of the planned radius about its frame's origin."""
    return [
        Finding("tip_radius_m", _radius_error(planned, rigid, name), contact=name)
        for name in planned.fingers
    ]


def _radius_error(planned: PlannedRobot, rigid: RigidRobot, name: str) -> float:
    if name not in rigid.tip_shapes:
        return float("inf")
    sphere = rigid.shapes.geometryObjects[rigid.tip_shapes[name]].geometry
    return abs(float(sphere.radius) - planned.fingers[name].tip_radius)


def _refuse_unfit(summary: UrdfSummary, planned: PlannedRobot, where: str) -> None:
    meshes = [shape.name for shape in summary.collisions if shape.kind == "mesh"]
    if meshes:
        raise PlanFileError(
            f"collision {meshes[0]!r} is a mesh", where=where, mend="use primitive shapes"
        )
    links = [finger.tip_frame for finger in planned.fingers.values()]
    links += [link for pair in planned.never_touch for link in pair]
    for link in links:
        if link not in summary.links:
            # Pinocchio would answer with an index that ends the process later.
            raise PlanFileError(
                f"names the unknown link {link!r}", where=WHERE, mend="use links of its URDF"
            )


def _sphere_at(model: Any, shapes: Any, frame: int) -> int | None:
    """Index of the sphere of a link that is centred at the link's origin."""
    origin = model.frames[frame].placement.translation
    for index, shape in enumerate(shapes.geometryObjects):
        if shape.parentFrame != frame or not isinstance(shape.geometry, coal.Sphere):
            continue
        if np.max(np.abs(shape.placement.translation - origin)) <= _AT_ORIGIN:
            return index
    return None
