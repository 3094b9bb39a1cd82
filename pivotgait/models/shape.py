"""A collision or visual shape: a convex primitive (or a mesh) and its pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from pivotgait.frozen import Array, FrozenArrays

ShapeKind = Literal["box", "sphere", "capsule", "cylinder", "mesh"]
PRIMITIVES: tuple[ShapeKind, ...] = ("box", "sphere", "capsule", "cylinder")


@dataclass(frozen=True, eq=False)
class Shape(FrozenArrays):
    """A shape in the frame of whoever holds it (a URDF link, a tool).

    Attributes:
        name: of its ``<collision>`` or ``<visual>`` element, or ``<link>_<place>`` if it has none.
        kind: one of box, sphere, capsule, cylinder, mesh.
        size: [m]; box (x, y, z) side lengths; sphere (radius,); capsule and cylinder
            (radius, length) along the shape's own z axis, a capsule's length without its two
            caps; mesh (x, y, z) scale factors.
        rotation: (3, 3) holder <- shape.
        translation: (3,) shape's origin in the holder's frame [m].
        mesh: file of a mesh, else None.
    """

    name: str
    kind: ShapeKind
    size: tuple[float, ...]
    rotation: Array
    translation: Array
    mesh: Path | None = None

    def shifted(self, offset: Array) -> Shape:
        """The same shape seen from a frame whose origin lies at ``offset`` (3,) [m], same axes."""
        return replace(self, translation=self.translation - offset)

    def to_local(self, point: Array) -> Array:
        """(..., 3) points of the holder's frame in the shape's own frame [m]."""
        local: Array = (point - self.translation) @ self.rotation
        return local
