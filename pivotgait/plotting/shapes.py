"""The tool's collision shapes as meshes in the tool frame."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pivotgait.models.shape import Shape
from pivotgait.models.urdf import check_urdf
from pivotgait.plans.plan import PlannedTool
from pivotgait.plotting import mesh
from pivotgait.plotting.render import Surface

Array = NDArray[np.float64]
_HIDDEN = 1e-5
_MATERIALS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"#45413E": ("handle", "grip", "scale"), "#7D8793": ("tip",)}
)
_STEEL = "#C2C9D2"


def tool_surfaces(tool: PlannedTool) -> tuple[Surface, ...]:
    """One surface per collision shape of ``tool``, in the tool frame [m].

    Grips are dark and metal is grey, told apart by the shapes' names. Faces inside another shape
    are left out: nobody sees them, and a painter would mix them with those in front.

    Raises:
        UrdfError: if the tool's URDF is broken.
    """
    summary = check_urdf(tool.urdf, where=f"URDF of {tool.name}")
    shapes = [
        shape.shifted(tool.centre_of_mass_in_root)
        for shape in summary.links[summary.root].collisions
        if shape.kind != "mesh"
    ]
    surfaces = []
    for shape in shapes:
        faces = shape_faces(shape)
        middle = faces.mean(axis=1)
        inside = [_depth(other, middle) > _HIDDEN for other in shapes if other is not shape]
        seen = ~np.any(inside, axis=0) if inside else np.full(len(faces), True)
        surfaces.append(Surface(faces[seen], material(shape.name)))
    return tuple(surfaces)


def shape_faces(shape: Shape, largest_face: float = mesh.LARGEST_FACE) -> Array:
    """(F, 4, 3) faces of a primitive in its holder's frame [m], none much longer than told."""
    if shape.kind == "box":
        faces = mesh.box(shape.size, largest_face)
    elif shape.kind == "sphere":
        faces = mesh.sphere(shape.size[0])
    else:
        radius, length = shape.size
        faces = (
            mesh.cylinder(radius, length, largest_face)
            if shape.kind == "cylinder"
            else mesh.capsule(radius, length)
        )
    return np.asarray(faces @ shape.rotation.T + shape.translation)


def _depth(shape: Shape, points: Array) -> Array:
    """How deep (...,) points (..., 3) lie inside ``shape`` [m]; negative outside."""
    local = shape.to_local(points)
    if shape.kind == "box":
        return np.asarray(np.min(np.array(shape.size) / 2 - np.abs(local), axis=-1))
    across = np.linalg.norm(local[..., :2], axis=-1)
    if shape.kind == "cylinder":
        radius, length = shape.size
        return np.asarray(np.minimum(radius - across, length / 2 - np.abs(local[..., 2])))
    half = shape.size[1] / 2 if shape.kind == "capsule" else 0.0
    beyond = local[..., 2] - np.clip(local[..., 2], -half, half)
    return np.asarray(shape.size[0] - np.hypot(across, beyond))


def material(name: str) -> str:
    """Colour of a tool's shape by its name: dark for grips, grey for metal."""
    for colour, words in _MATERIALS.items():
        if any(word in name.lower() for word in words):
            return colour
    return _STEEL
