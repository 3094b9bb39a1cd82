"""The table under the tool: a plane with a grid, and the tool's shadow on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from pivotgait.plotting.render import Camera, Surface, face_normals

_TABLE, _LINES, _SHADOW = "#F0EDE6", "#DFDACE", "#CFCABD"
_GRID = 0.05
_REACH = 1.0


def draw_ground(axes: Any, camera: Camera, height: float, bodies: Sequence[Surface]) -> None:
    """Fill ``axes`` with the table, ruled every 50 mm, and the shadow of ``bodies``.

    Args:
        axes: plain 2D axes in the camera's coordinates [m].
        camera: looks down on the table.
        height: world z of the table [m].
        bodies: what casts a shadow under a light straight above.
    """
    centre = np.concatenate([s.faces.reshape(-1, 3) for s in bodies]).mean(axis=0)
    centre = _GRID * np.round(centre / _GRID)
    ticks = np.arange(-_REACH, _REACH + _GRID / 2, _GRID)
    ends = np.full_like(ticks, _REACH)
    along = np.stack((np.column_stack((ticks, -ends)), np.column_stack((ticks, ends))), axis=1)
    lines = np.concatenate((along, along[..., ::-1]))
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * _REACH

    def flat(points: np.ndarray) -> np.ndarray:
        raised = np.concatenate((points, np.zeros((*points.shape[:-1], 1))), axis=-1)
        raised[..., :2] += centre[:2]
        raised[..., 2] = height
        return camera.project(raised)[..., :2]

    axes.fill(*flat(square).T, color=_TABLE, lw=0, zorder=0)
    axes.add_collection(
        LineCollection(list(flat(lines)), colors=_LINES, linewidths=0.5, zorder=0.5)
    )
    shadows = [camera.project(_dropped(body.faces, height))[..., :2] for body in bodies]
    axes.add_collection(
        PolyCollection(
            list(np.concatenate(shadows)),
            facecolors=_SHADOW,
            edgecolors=_SHADOW,
            linewidths=0.4,
            rasterized=True,
            zorder=1,
        )
    )


def _dropped(faces: np.ndarray, height: float) -> np.ndarray:
    shadow = faces[face_normals(faces)[:, 2] > 0.0]  # the sides below fall into the same shadow
    shadow[..., 2] = height
    return shadow
