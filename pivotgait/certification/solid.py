"""The tool as its URDF text describes it: mass properties and collision shapes, by Pinocchio."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from pivotgait.certification.certificate import Finding
from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array
from pivotgait.models.urdf import UrdfSummary, check_urdf
from pivotgait.plans import PlannedTool

_TIP_AT_PIVOT = 1e-6


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex collision shape, placed in the tool frame (origin at the centre of mass).

    Attributes:
        geometry: the Coal shape.
        rotation: (3, 3) tool <- shape.
        translation: (3,) of the shape's origin in the tool frame [m].
    """

    geometry: Any
    rotation: Array
    translation: Array


@dataclass(frozen=True, eq=False)
class RigidTool:
    """What the URDF text says of the tool.

    Attributes:
        mass: [kg].
        centre_of_mass: (3,) in the root link's frame [m].
        inertia: (3, 3) at the centre of mass, axes of the root link [kg m^2].
        tip: the sphere whose centre is nearest to the planned pivot, None without any sphere.
        body: all shapes but the tip, or all of them if the tip is not at the pivot.
    """

    mass: float
    centre_of_mass: Array
    inertia: Array
    tip: Solid | None
    body: tuple[Solid, ...]

    @property
    def tip_radius(self) -> float:
        """Radius of the tip's sphere [m], 0 without one."""
        return 0.0 if self.tip is None else float(self.tip.geometry.radius)

    @property
    def solids(self) -> tuple[Solid, ...]:
        """All shapes."""
        tip = () if self.tip is None or self.tip in self.body else (self.tip,)
        return (*tip, *self.body)


def rigid_tool(planned: PlannedTool) -> RigidTool:
    """Parse the tool's URDF, independently of the numbers the plan gives beside it.

    Args:
        planned: the tool of a plan.

    Raises:
        UrdfError: if the text must not reach the native parsers.
        PlanFileError: if it is not one rigid body of primitive shapes.
    """
    where = f"urdf of tool {planned.name!r}"
    summary = check_urdf(planned.urdf, where=where)
    _refuse_unfit(summary, where)
    try:
        # On a free joint, so that Pinocchio keeps the root's mass and joins links that are fixed.
        model = pin.buildModelFromXML(planned.urdf, pin.JointModelFreeFlyer())
        shapes = pin.buildGeomFromUrdfString(model, planned.urdf, pin.GeometryType.COLLISION)
    except (RuntimeError, ValueError) as error:
        raise PlanFileError(f"Pinocchio: {error}", where=where, mend="mend the URDF") from error
    if shapes.ngeoms != len(summary.collisions):
        # Pinocchio drops what it cannot parse, and a shape that is gone collides with nothing.
        raise PlanFileError("Pinocchio dropped a shape", where=where, mend="mend the URDF")
    solids = [_solid(each, planned, where) for each in shapes.geometryObjects]
    spheres = [each for each in solids if isinstance(each.geometry, coal.Sphere)]
    tip = min(spheres, key=lambda each: _from_pivot(each, planned), default=None)
    at_pivot = tip is not None and _from_pivot(tip, planned) <= _TIP_AT_PIVOT
    inertia = model.inertias[1]
    return RigidTool(
        mass=float(inertia.mass),
        centre_of_mass=np.array(inertia.lever),
        inertia=np.array(inertia.inertia),
        tip=tip,
        body=tuple(each for each in solids if not (at_pivot and each is tip)),
    )


def check_tool(planned: PlannedTool, rigid: RigidTool) -> Iterator[Finding]:
    """The plan's mass, inertia, centre of mass and pivot are those of its URDF, and physical."""
    yield Finding("tool_mass", abs(planned.mass / rigid.mass - 1.0))
    offset = planned.centre_of_mass_in_root - rigid.centre_of_mass
    yield Finding("tool_centre_m", float(np.linalg.norm(offset)))
    scale = float(np.linalg.norm(rigid.inertia))
    yield Finding("tool_inertia", float(np.linalg.norm(planned.inertia - rigid.inertia)) / scale)
    principal = np.linalg.eigvalsh(0.5 * (planned.inertia + planned.inertia.T))
    # No distribution of mass has a principal moment below 0 or above the sum of the other two.
    triangle = float(principal[0] + principal[1] - principal[2])
    yield Finding("tool_inertia_physical", min(float(principal[0]), triangle) / scale)
    missed = np.inf if rigid.tip is None else _from_pivot(rigid.tip, planned)
    yield Finding("tool_pivot_m", float(missed))


def _refuse_unfit(summary: UrdfSummary, where: str) -> None:
    moving = [joint.name for joint in summary.joints.values() if joint.kind != "fixed"]
    if moving:
        raise PlanFileError(
            f"has moving joint {moving[0]!r}", where=where, mend="a hand tool is one rigid body"
        )
    meshes = [shape.name for shape in summary.collisions if shape.kind == "mesh"]
    if meshes:
        raise PlanFileError(
            f"collision {meshes[0]!r} is a mesh", where=where, mend="use primitive shapes"
        )
    if not summary.collisions:
        raise PlanFileError("has no collision shape", where=where, mend="add <collision>")
    if summary.mass <= 0.0:
        raise PlanFileError("has no mass", where=where, mend="add <inertial>")


def _solid(shape: Any, planned: PlannedTool, where: str) -> Solid:
    if not isinstance(shape.geometry, coal.Box | coal.Sphere | coal.Capsule | coal.Cylinder):
        kind = type(shape.geometry).__name__
        raise PlanFileError(f"shape {kind} is not a primitive", where=where, mend="use primitives")
    translation = np.array(shape.placement.translation) - planned.centre_of_mass_in_root
    return Solid(shape.geometry, np.array(shape.placement.rotation), translation)


def _from_pivot(solid: Solid, planned: PlannedTool) -> float:
    return float(np.linalg.norm(solid.translation - planned.pivot_in_tool))
