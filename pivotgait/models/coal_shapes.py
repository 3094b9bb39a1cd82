"""Shapes as Coal collision objects."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np

from pivotgait.frozen import Array
from pivotgait.models.shape import Shape


def coal_geometry(shape: Shape) -> Any:
    """The ``coal.CollisionGeometry`` of a primitive, centred at its own origin."""
    makers = {
        "box": coal.Box,
        "sphere": coal.Sphere,
        "capsule": coal.Capsule,
        "cylinder": coal.Cylinder,
    }
    if shape.kind not in makers:
        raise ValueError(f"shape {shape.name!r} is a {shape.kind}, not a primitive")
    return makers[shape.kind](*shape.size)


def coal_object(shape: Shape) -> Any:
    """The ``coal.CollisionObject`` of a primitive, placed in the frame that holds the shape."""
    return coal.CollisionObject(coal_geometry(shape), _pose(shape.rotation, shape.translation))


def ball_distance(shape: Shape, centre: Array, radius: float) -> tuple[float, Array, Array]:
    """Distance [m] from a ball to a shape by Coal, and the nearest points of shape and ball.

    Args:
        shape: a primitive.
        centre: (3,) of the ball, in the frame that holds the shape [m].
        radius: of the ball [m].

    Returns:
        distance (negative when they overlap), point (3,) on the shape, point (3,) on the ball.

    Raises:
        ValueError: for a centre that is not finite; Coal may call such a pose free.
    """
    if not np.all(np.isfinite(centre)):
        raise ValueError(f"ball centre {centre} is not finite")
    ball = coal.CollisionObject(coal.Sphere(radius), _pose(np.eye(3), centre))
    result = coal.DistanceResult()
    distance = float(coal.distance(coal_object(shape), ball, coal.DistanceRequest(), result))
    return distance, np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())


def _pose(rotation: Array, translation: Array) -> Any:
    return coal.Transform3s(np.array(rotation), np.array(translation))
