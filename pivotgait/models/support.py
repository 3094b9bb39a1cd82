"""Balls whose convex hull covers a shape: the shape's height over a plane in closed form."""

from __future__ import annotations

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
