"""Quadrilateral meshes of the shapes we draw: boxes and surfaces of revolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
LARGEST_FACE = 0.008
"""Faces longer than this [m] are divided, or sorting them by depth would go wrong."""


def _steps(length: float, face: float = LARGEST_FACE) -> int:
    return max(1, int(np.ceil(length / face)))


def _grid_faces(grid: Array) -> Array:
    """(F, 4, 3) quads of a (n, m, 3) grid of points, counter-clockwise seen from outside."""
    corners = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def box(size: ArrayLike, face: float = LARGEST_FACE) -> Array:
    """(F, 4, 3) faces, no longer than ``face``, of a box of ``size`` about the origin [m]."""
    half = np.asarray(size, dtype=float) / 2
    faces = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for sign in (-1.0, 1.0):
            a = np.linspace(-half[u], half[u], _steps(2 * half[u], face) + 1)
            b = sign * np.linspace(-half[v], half[v], _steps(2 * half[v], face) + 1)
            grid = np.empty((a.size, b.size, 3))
            grid[..., axis] = sign * half[axis]
            grid[..., u], grid[..., v] = a[:, None], b[None, :]
            faces.append(_grid_faces(grid))
    return np.concatenate(faces)


def revolve(profile: ArrayLike, segments: int = 20) -> Array:
    """(F, 4, 3) faces of a profile turned about z.

    Args:
        profile: (n, 2) radius and height [m], from the bottom to the top.
        segments: number of faces around.
    """
    radius, height = np.asarray(profile, dtype=float).T
    angle = np.linspace(0.0, 2 * np.pi, segments + 1)[:, None]
    grid = np.stack(
        (
            radius * np.cos(angle),
            radius * np.sin(angle),
            np.broadcast_to(height, (segments + 1, radius.size)),
        ),
        axis=-1,
    )
    return _grid_faces(grid)


def cylinder(radius: float, length: float, face: float = LARGEST_FACE) -> Array:
    """(F, 4, 3) faces of a cylinder along z centred at the origin [m]."""
    height = np.linspace(-length / 2, length / 2, _steps(length, face) + 1)
    side = np.column_stack((np.full(height.size, radius), height))
    disc = np.linspace(0.0, radius, _steps(radius, face) + 1)[:-1]
    bottom = np.column_stack((disc, np.full(disc.size, -length / 2)))
    around = max(20, _steps(2 * np.pi * radius, face))
    return revolve(np.vstack((bottom, side, bottom[::-1] * (1.0, -1.0))), around)


def capsule(radius: float, length: float) -> Array:
    """(F, 4, 3) faces of a capsule along z, ``length`` without its round ends [m]."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, 12)
    ends = np.where(turn < 0, -length / 2, length / 2)
    profile = np.column_stack((radius * np.cos(turn), radius * np.sin(turn) + ends))
    middle = np.linspace(-length / 2, length / 2, _steps(length) + 1)[1:-1]
    side = np.column_stack((np.full(middle.size, radius), middle))
    return revolve(np.vstack((profile[:6], side, profile[6:])))


def sphere(radius: float) -> Array:
    """(F, 4, 3) faces of a sphere [m]."""
    return capsule(radius, 0.0)


def cone(height: float, slope: float) -> Array:
    """(F, 4, 3) faces of an open cone with its apex at the origin, widening along +z.

    Args:
        height: along z [m].
        slope: radius over height.
    """
    return revolve([[0.0, 0.0], [height * slope, height]], segments=36)


def arrow(length: float, width: float) -> Array:
    """(F, 4, 3) faces of an arrow from the origin along +z [m]; ``width`` of its shaft."""
    head = min(4.0 * width, 0.6 * length)
    shaft = length - head
    height = np.linspace(0.0, shaft, _steps(shaft) + 1)
    side = np.column_stack((np.full(height.size, width / 2), height))
    return revolve(np.vstack(([0.0, 0.0], side, [1.3 * width, shaft], [0.0, length])), segments=12)
