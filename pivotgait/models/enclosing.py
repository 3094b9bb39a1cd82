"""The smaller of an oriented box and a capsule around a mesh: fast, convex and never too small."""

from __future__ import annotations

import math
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from pivotgait.exceptions import UrdfError
from pivotgait.frozen import Array
from pivotgait.models.shape import Shape

_FACETS = 12
"""Largest facets of the hull tried as the box's bottom; an optimal box has one flush."""
_TURNS = np.radians(np.arange(90.0))
"""Angles [rad] tried for the box's sides about the normal of its bottom."""
_STEP = 1e-6
"""Sizes are rounded up to whole steps [m], which covers the rounding of poses in the text."""


def enclosing_primitive(mesh: Shape, *, where: str) -> Shape:
    """A box, capsule or sphere that holds every vertex of a mesh, in the mesh's holder.

    Args:
        mesh: of kind ``"mesh"``, with its file, scale and pose.
        where: the shape's name in messages.

    Raises:
        UrdfError: for a file without readable, finite vertices.
    """
    points = mesh.translation + read_vertices(mesh, where=where) @ mesh.rotation.T
    corners, normals = _hull(points)
    box = _box(mesh.name, corners, normals)
    axes = (*box.rotation.T, _principal(corners)[0])
    around = min((_capsule(mesh.name, corners, axis) for axis in axes), key=volume)
    return min(box, around, key=volume)


def read_vertices(mesh: Shape, *, where: str) -> Array:
    """(N, 3) vertices [m] of a mesh file, scaled, in the mesh's own frame.

    Raises:
        UrdfError: if Coal cannot read them or one is not finite.
    """
    mend = "save the mesh again as binary STL"
    try:
        loaded = coal.MeshLoader().load(str(mesh.mesh), np.array(mesh.size))
        points = np.array(loaded.vertices(), dtype=float)
    except (ValueError, RuntimeError) as error:
        name = Path(str(mesh.mesh)).name
        raise UrdfError(f"mesh {name!r} cannot be read", where=where, mend=mend) from error
    if points.ndim != 2 or len(points) == 0 or not np.all(np.isfinite(points)):
        raise UrdfError("the mesh has no finite vertices", where=where, mend=mend)
    return points


def volume(shape: Shape) -> float:
    """Volume of a box, sphere or capsule [m^3]."""
    if shape.kind == "box":
        return float(np.prod(shape.size))
    radius, length = shape.size[0], sum(shape.size[1:])
    return float(np.pi * radius**2 * (4.0 / 3.0 * radius + length))


def _hull(points: Array) -> tuple[Array, Array]:
    """Corners (N, 3) of the convex hull and unit normals (M, 3) of its largest facets."""
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # flat or fewer than four points
        return points, np.zeros((0, 3))
    triangles = points[hull.simplices]
    sides = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    areas = np.linalg.norm(np.cross(*sides), axis=1)
    # Triangles of one facet share their normal.
    normals, facet = np.unique(np.round(hull.equations[:, :3], 3), axis=0, return_inverse=True)
    largest = np.argsort(-np.bincount(facet.ravel(), weights=areas), kind="stable")[:_FACETS]
    chosen = normals[largest]
    return points[hull.vertices], chosen / np.linalg.norm(chosen, axis=1, keepdims=True)


def _principal(points: Array) -> Array:
    """(3, 3) rows: unit directions of largest to smallest spread."""
    offsets = points - points.mean(axis=0)
    return np.asarray(np.linalg.eigh(offsets.T @ offsets)[1].T[::-1])


def _box(name: str, corners: Array, normals: Array) -> Shape:
    """The smallest box among those on the holder's axes, the principal axes and the facets."""
    frames = [np.eye(3), *(_turned(axis) for axis in _principal(corners))]
    frames += [_flush(corners, normal) for normal in normals]
    rotation = min(frames, key=lambda frame: float(np.prod(np.ptp(corners @ frame, axis=0))))
    local = corners @ rotation
    low, high = local.min(axis=0), local.max(axis=0)
    size = tuple(_up(float(side)) for side in high - low)
    return Shape(name, "box", size, rotation, rotation @ (0.5 * (low + high)))


def _flush(corners: Array, normal: Array) -> Array:
    """Rotation holder <- box: z along ``normal``, turned about it for the smallest rectangle."""
    rotation = _turned(normal)
    flat = corners @ rotation[:, :2]
    cos, sin = np.cos(_TURNS)[:, None], np.sin(_TURNS)[:, None]
    along, across = flat[:, 0] * cos + flat[:, 1] * sin, flat[:, 1] * cos - flat[:, 0] * sin
    best = _TURNS[np.argmin(np.ptp(along, axis=1) * np.ptp(across, axis=1))]
    turn = np.array([[np.cos(best), -np.sin(best)], [np.sin(best), np.cos(best)]])
    return np.column_stack([rotation[:, :2] @ turn, rotation[:, 2]])


def _capsule(name: str, points: Array, axis: Array) -> Shape:
    """The capsule along ``axis`` around the least circle of the points' projections."""
    rotation = _turned(axis)
    local = points @ rotation
    middle = _least_circle(local[:, :2])
    off = np.linalg.norm(local[:, :2] - middle, axis=1)
    radius = _up(float(off.max()))
    # A point at distance d off the axis lies in a ball whose centre is sqrt(r^2 - d^2) off it.
    reach = np.sqrt(radius**2 - off**2)
    low, high = float((local[:, 2] + reach).min()), float((local[:, 2] - reach).max())
    centre = rotation @ np.array([*middle, 0.5 * (low + high)])
    if low >= high:
        return Shape(name, "sphere", (_up(radius),), np.eye(3), centre)
    return Shape(name, "capsule", (radius, _up(high - low)), rotation, centre)


def _least_circle(points: Array) -> Array:
    """(2,) centre, nearly that of the smallest circle around (N, 2) points [m].

    Steps towards the farthest point, each shorter than the last (Badoiu and Clarkson, 2003).
    """
    centre: Array = 0.5 * (points.min(axis=0) + points.max(axis=0))
    for step in range(1, 50):
        farthest = points[np.argmax(np.sum((points - centre) ** 2, axis=1))]
        centre = centre + (farthest - centre) / (step + 5)
    return centre


def _turned(direction: Array) -> Array:
    """A rotation matrix (3, 3) whose third column is ``direction`` (3,), of unit length."""
    return np.array(pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), direction).matrix())


def _up(length: float) -> float:
    """``length`` [m] rounded up to whole steps, with one to spare."""
    return round((math.ceil(length / _STEP) + 1) * _STEP, 9)
