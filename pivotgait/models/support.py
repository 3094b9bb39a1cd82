"""Balls whose convex hull covers a shape: the shape's height over a plane in closed form."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product

import numpy as np

from pivotgait.frozen import Array
from pivotgait.models.shape import Shape

RIM_POINTS = 32
"""Corners of the polygon around a cylinder's rim; it overshoots the radius by 0.5 %."""


def support_balls(shape: Shape) -> tuple[Array, Array]:
    """Centres (P, 3) and radii (P,) of balls whose convex hull contains ``shape`` [m].

    Exact for spheres and capsules (ball ends) and boxes (corners of radius 0); a cylinder's rims
    are polygons around the circle, so its hull is slightly larger. The lowest point of the hull
    along any direction z is ``min(centres @ z - radii)``.
    """
    if shape.kind == "sphere":
        local, radius = np.zeros((1, 3)), shape.size[0]
    elif shape.kind == "box":
        signs = np.array(list(product((-0.5, 0.5), repeat=3)))
        local, radius = signs * np.array(shape.size), 0.0
    elif shape.kind == "capsule":
        local = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * shape.size[1]
        radius = shape.size[0]
    elif shape.kind == "cylinder":
        angle = 2.0 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
        reach = shape.size[0] / np.cos(np.pi / RIM_POINTS)
        rim = np.stack((reach * np.cos(angle), reach * np.sin(angle)), axis=-1)
        ends = np.repeat([-0.5, 0.5], RIM_POINTS) * shape.size[1]
        local, radius = np.column_stack((np.tile(rim, (2, 1)), ends)), 0.0
    else:
        raise ValueError(f"shape {shape.name!r} is a {shape.kind}, not a primitive")
    return local @ shape.rotation.T + shape.translation, np.full(len(local), radius)


def covering_balls(shapes: Iterable[Shape]) -> tuple[Array, Array]:
    """Centres (P, 3) and radii (P,) of :func:`support_balls` of all shapes [m]; P may be 0."""
    balls = [support_balls(shape) for shape in shapes]
    if not balls:
        return np.zeros((0, 3)), np.zeros(0)
    centres, radii = zip(*balls, strict=True)
    return np.concatenate(centres), np.concatenate(radii)


def height_over_table(
    centres: Array, radii: Array, pivot: Array, tip_radius: float, rotation: Array
) -> Array:
    """Height of the lowest of some balls on a tool whose tip rests on the table [m].

    Args:
        centres: (P, 3) of the balls, tool frame [m].
        radii: (P,) [m].
        pivot: (3,) centre of the tip sphere, tool frame [m].
        tip_radius: of that sphere [m].
        rotation: (..., 3, 3) world <- tool.

    Returns:
        (...,); negative where a ball reaches below the table, infinite without any ball.
    """
    lever = centres - pivot
    rise = np.einsum("...j,pj->...p", np.asarray(rotation, dtype=float)[..., 2, :], lever)
    return np.asarray(np.min(rise - radii, axis=-1, initial=np.inf) + tip_radius)
