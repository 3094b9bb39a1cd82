"""The hand tool: one rigid body of primitives with a tip sphere and a handle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pivotgait.exceptions import UnknownNameError, UrdfError
from pivotgait.frozen import Array, FrozenArrays, frozen
from pivotgait.models.handle import Handle, SurfacePoint, verify_place
from pivotgait.models.shape import PRIMITIVES, Shape
from pivotgait.models.support import covering_balls, height_over_table
from pivotgait.models.urdf import UrdfLink, UrdfSummary, read_urdf


@dataclass(frozen=True, eq=False)
class Tool(FrozenArrays):
    """A tool as the planners see it.

    The tool frame has its origin at the centre of mass and the axes of the URDF's root link. The
    pivot is the centre of the tip sphere: the sphere stays tangent to the table while the tool
    turns about its centre, which stays one tip radius above the table.

    Attributes:
        name: of the URDF's robot.
        urdf: its whole text.
        urdf_path: the file it was read from.
        mass: [kg].
        inertia: (3, 3) at the centre of mass in the tool frame [kg m^2].
        centre_of_mass_in_root: (3,) origin of the tool frame in the URDF's root link [m].
        pivot_in_tool: (3,) centre of the tip sphere in the tool frame [m].
        tip: the tip sphere, in the tool frame.
        shapes: every collision shape, the tip included, in the tool frame.
        handle: where fingers may touch.
    """

    name: str
    urdf: str
    urdf_path: Path
    mass: float
    inertia: Array
    centre_of_mass_in_root: Array
    pivot_in_tool: Array
    tip: Shape
    shapes: tuple[Shape, ...]
    handle: Handle

    @property
    def tip_radius(self) -> float:
        """Radius of the tip sphere [m]."""
        return self.tip.size[0]

    @cached_property
    def _support(self) -> tuple[Array, Array]:
        centres, radii = covering_balls(each for each in self.shapes if each is not self.tip)
        return frozen(centres), frozen(radii)

    def support_points(self) -> tuple[Array, Array]:
        """Centres (P, 3) in the tool frame and radii (P,) of balls that cover all but the tip [m].

        The tool's lowest point apart from the tip is the least of ``z - radius`` over them.
        """
        return self._support

    def height(self, rotation: Array) -> Array:
        """Height of the lowest point, apart from the tip, over the table the tip rests on [m].

        Args:
            rotation: (..., 3, 3) world <- tool.

        Returns:
            (...,); negative where the tool reaches below the table.
        """
        centres, radii = self.support_points()
        return height_over_table(centres, radii, self.pivot_in_tool, self.tip_radius, rotation)

    def place(self, along: float, around: float, *, where: str = "handle") -> SurfacePoint:
        """A place on the handle (see :meth:`Handle.place`), verified by Coal.

        Args:
            along: along the handle's axis [m].
            around: about the handle's axis [rad].
            where: name of the place in messages.

        Raises:
            SceneError: off the handle, on an edge, or hidden by another shape of the tool.
        """
        place = self.handle.place(along, around, where=where)
        verify_place(place, self.shapes, where=where)
        return place


def load_tool(
    path: Path | str,
    *,
    tip: str,
    handle: Sequence[str],
    origin: Array,
    axis: Array,
    zero: Array,
    roots: Sequence[Path] = (),
) -> Tool:
    """Read a tool from its URDF.

    Args:
        path: of the URDF: a single link of primitives, with mass properties.
        tip: name of the collision sphere at the tip.
        handle: names of the collision shapes that form the handle.
        origin: (3,) start of the handle's axis in the root link's frame [m].
        axis: (3,) direction of the handle's axis, any length.
        zero: (3,) direction of zero angle around the axis, normal to it, any length.
        roots: folders in which meshes of visuals may lie, besides the file's own.

    Raises:
        UrdfError: for a URDF that is broken or is no tool.
        UnknownNameError: for a shape the URDF does not have.
    """
    summary = read_urdf(path, roots)
    where = Path(path).name
    link = _single_link(summary, where)
    if link.inertial is None:
        raise UrdfError(
            "the tool has no mass", where=where, mend="give <inertial> with mass and inertia"
        )
    centre = link.inertial.centre_of_mass
    shapes = {shape.name: shape.shifted(centre) for shape in link.collisions}
    for name in (tip, *handle):
        if name not in shapes:
            raise UnknownNameError("collision shape", name, shapes, where=where)
    if shapes[tip].kind != "sphere":
        what = f"the tip {tip!r} is a {shapes[tip].kind}"
        raise UrdfError(what, where=where, mend="put a small sphere where the tool meets the table")
    return Tool(
        name=summary.name,
        urdf=summary.text,
        urdf_path=Path(path),
        mass=link.inertial.mass,
        inertia=link.inertial.inertia,
        centre_of_mass_in_root=centre,
        pivot_in_tool=shapes[tip].translation,
        tip=shapes[tip],
        shapes=tuple(shapes.values()),
        handle=Handle(
            tuple(shapes[name] for name in handle),
            np.asarray(origin, dtype=float) - centre,
            axis / np.linalg.norm(axis),
            zero / np.linalg.norm(zero),
        ),
    )


def _single_link(summary: UrdfSummary, where: str) -> UrdfLink:
    if len(summary.links) != 1:
        # Bullet gives fixed child links wrong mass properties.
        mend = "merge them into one link with one <inertial>"
        raise UrdfError(
            f"a tool is one rigid link, found {len(summary.links)}", where=where, mend=mend
        )
    link = summary.links[summary.root]
    for shape in link.collisions:
        if shape.kind not in PRIMITIVES:
            mend = "replace it by boxes, capsules, cylinders or spheres"
            raise UrdfError(f"collision {shape.name!r} is a mesh", where=where, mend=mend)
    return link
