"""Collision shapes and our own meshes as viser nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.models.shape import Shape
from pivotgait.plotting import mesh

if TYPE_CHECKING:
    from viser import SceneApi

Rgb = tuple[int, int, int]


def rgb(colour: str) -> Rgb:
    """``#rrggbb`` as three numbers from 0 to 255."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue


def add_shape(scene: SceneApi, name: str, shape: Shape, colour: str) -> Any:
    """Add a primitive to ``scene`` as node ``name`` in its holder's frame; None for a mesh."""
    if shape.kind == "mesh":
        return None  # the file of a mesh is not part of a plan
    if shape.kind == "capsule":
        radius, length = shape.size
        node = add_faces(scene, name, mesh.capsule(radius, length), colour)
    elif shape.kind == "box":
        node = scene.add_box(name, rgb(colour), np.array(shape.size))
    elif shape.kind == "sphere":
        node = scene.add_icosphere(name, shape.size[0], rgb(colour))
    else:
        radius, length = shape.size
        node = scene.add_cylinder(name, radius, length, rgb(colour))
    node.position = shape.translation
    node.wxyz = Rotation.from_matrix(shape.rotation).as_quat(scalar_first=True)
    return node


def add_faces(
    scene: SceneApi,
    name: str,
    faces: Array,
    colour: str,
    *,
    opacity: float | None = None,
    position: ArrayLike = (0.0, 0.0, 0.0),
    wxyz: ArrayLike = (1.0, 0.0, 0.0, 0.0),
) -> Any:
    """Add quads (F, 4, 3) [m] as a smooth mesh; translucent ones are seen from both sides."""
    vertices, triangles = triangulate(faces)
    return scene.add_mesh_simple(
        name,
        vertices,
        triangles,
        color=rgb(colour),
        opacity=opacity,
        side="front" if opacity is None else "double",
        cast_shadow=opacity is None,
        receive_shadow=opacity is None,
        position=np.asarray(position, dtype=float),
        wxyz=np.asarray(wxyz, dtype=float),
    )


def triangulate(faces: Array) -> tuple[Array, Array]:
    """Shared vertices (V, 3) and triangles (T, 3) of quads (F, 4, 3), those without area left out.

    Corners nearer than a nanometre become one, so that a viewer can shade across edges.
    """
    corners, place = np.unique(np.round(faces.reshape(-1, 3), 9), axis=0, return_inverse=True)
    quads = place.reshape(-1, 4)
    triangles = np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))
    a, b, c = triangles.T
    return corners, triangles[(a != b) & (b != c) & (c != a)]
