"""A small painter: shaded surfaces on plain 2D axes, far faces first.

Matplotlib's own 3D axes sort whole artists, which lets a far finger cover the tool. Here all
faces of a picture are sorted together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Surface:
    """Faces of one colour.

    Attributes:
        faces: (F, 4, 3) world [m], counter-clockwise seen from outside.
        colour: any matplotlib colour.
        alpha: 1 for solid bodies, whose far side is left out.
    """

    faces: Array
    colour: str
    alpha: float = 1.0


@dataclass(frozen=True, eq=False)
class Camera:
    """Orthographic camera: lengths across the view keep their scale.

    Attributes:
        axes: (3, 3) rows right, up and towards the eye, in the world.
    """

    axes: Array

    @classmethod
    def looking_from(cls, azimuth: float, elevation: float) -> Camera:
        """Camera with its eye in the direction of the two angles [rad], world z up."""
        eye = np.array(
            [
                np.cos(azimuth) * np.cos(elevation),
                np.sin(azimuth) * np.cos(elevation),
                np.sin(elevation),
            ]
        )
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        return cls(np.stack((right, np.cross(eye, right), eye)))

    def project(self, points: ArrayLike) -> Array:
        """(..., 3) across, up and depth (larger is nearer) of world points [m]."""
        return np.asarray(points, dtype=float) @ self.axes.T


def face_normals(faces: Array) -> Array:
    """(F, 3) unit normals of quads, zero for a face without area."""
    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return normal / np.where(length > 0.0, length, 1.0)


def paint(axes: Any, camera: Camera, surfaces: Sequence[Surface], *, zorder: float = 2.0) -> None:
    """Draw ``surfaces`` on 2D ``axes`` as one collection, lit from above the eye's left."""
    light = np.array([-0.35, 0.65, 0.67]) @ camera.axes
    polygons, depths, colours = [], [], []
    for surface in surfaces:
        normal = face_normals(surface.faces)
        seen = normal @ camera.axes[2] > 0.0 if surface.alpha == 1.0 else np.full(len(normal), True)
        projected = camera.project(surface.faces[seen])
        shade = 0.66 + 0.42 * np.clip(normal[seen] @ light, 0.0, None)
        if surface.alpha < 1.0:
            shade = np.ones_like(shade)
        rgba = np.empty((len(projected), 4))
        rgba[:, :3] = np.clip(np.outer(shade, to_rgb(surface.colour)), 0.0, 1.0)
        rgba[:, 3] = surface.alpha
        polygons.append(projected[..., :2])
        depths.append(projected[..., 2].mean(axis=1))
        colours.append(rgba)
    order = np.argsort(np.concatenate(depths), kind="stable")
    rgba = np.concatenate(colours)[order]
    solid = rgba[:, 3] == 1.0
    axes.add_collection(
        PolyCollection(
            list(np.concatenate(polygons)[order]),
            facecolors=rgba,
            # solid faces overlap their neighbours by a hair, or light shows through the seams
            edgecolors=np.where(solid[:, None], rgba, 0.0),
            linewidths=np.where(solid, 0.35, 0.0),
            antialiaseds=solid,
            rasterized=True,
            zorder=zorder,
        )
    )
