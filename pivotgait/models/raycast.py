"""A line against a convex primitive: where it is inside, and the normal where it leaves."""

from __future__ import annotations

import numpy as np

from pivotgait.frozen import Array
from pivotgait.models.shape import Shape

Span = tuple[float, float]
EMPTY: Span = (np.inf, -np.inf)
"""Span of a line that misses."""


def inside_span(shape: Shape, origin: Array, direction: Array) -> Span:
    """The stretch ``t0 <= t <= t1`` of ``origin + t direction`` that lies in ``shape``.

    Args:
        shape: a primitive.
        origin: (3,) in the frame that holds the shape [m].
        direction: (3,) unit vector in the same frame.

    Returns:
        (t0, t1) [m], or :data:`EMPTY`. Exact up to rounding: slabs and quadratics, no iteration.
    """
    o, d = shape.to_local(origin), direction @ shape.rotation
    if shape.kind == "sphere":
        return _ball(o, d, shape.size[0])
    if shape.kind == "box":
        return _slabs(o, d, np.array(shape.size) / 2.0)
    if shape.kind not in ("capsule", "cylinder"):
        raise ValueError(f"shape {shape.name!r} is a {shape.kind}, not a primitive")
    radius, half = shape.size[0], shape.size[1] / 2.0
    tube = _meet(_ball(o[:2], d[:2], radius), _slabs(o[2:], d[2:], np.array([half])))
    if shape.kind == "cylinder":
        return tube
    cap = np.array([0.0, 0.0, half])
    # A capsule is convex, so the spans of its tube and caps always join into one.
    return _join(tube, _join(_ball(o - cap, d, radius), _ball(o + cap, d, radius)))


def outward_normal(shape: Shape, point: Array, tolerance: float = 1e-6) -> Array | None:
    """Unit outward normal (3,) at a point of the surface, in the frame that holds the shape.

    None within ``tolerance`` [m] of an edge, where the normal is not unique.
    """
    p = shape.to_local(point)
    if shape.kind == "box":
        depth = np.array(shape.size) / 2.0 - np.abs(p)
        if np.count_nonzero(depth < tolerance) != 1:
            return None
        face = int(np.argmin(depth))
        local = np.zeros(3)
        local[face] = np.sign(p[face])
    elif shape.kind == "cylinder":
        radial = float(np.hypot(p[0], p[1]))
        on_side = shape.size[0] - radial < tolerance
        on_end = shape.size[1] / 2.0 - abs(p[2]) < tolerance
        if on_side == on_end:
            return None
        local = np.array([p[0], p[1], 0.0]) if on_side else np.array([0.0, 0.0, p[2]])
    else:
        half = shape.size[1] / 2.0 if shape.kind == "capsule" else 0.0
        local = p - np.array([0.0, 0.0, np.clip(p[2], -half, half)])
    normal: Array = shape.rotation @ (local / np.linalg.norm(local))
    return normal


def _ball(origin: Array, direction: Array, radius: float) -> Span:
    """Span inside a ball; in two dimensions, inside an endless tube."""
    a = float(direction @ direction)
    b, c = float(origin @ direction), float(origin @ origin) - radius**2
    if a < 1e-24:  # parallel to the tube
        return (-np.inf, np.inf) if c <= 0.0 else EMPTY
    discriminant = b * b - a * c
    if discriminant < 0.0:
        return EMPTY
    root = float(np.sqrt(discriminant))
    return (-b - root) / a, (-b + root) / a


def _slabs(origin: Array, direction: Array, half: Array) -> Span:
    span: Span = (-np.inf, np.inf)
    for o, d, h in zip(origin.tolist(), direction.tolist(), half.tolist(), strict=True):
        if abs(d) < 1e-12:
            if abs(o) > h:
                return EMPTY
            continue
        first, second = (-h - o) / d, (h - o) / d
        span = _meet(span, (min(first, second), max(first, second)))
    return span


def _meet(a: Span, b: Span) -> Span:
    low, high = max(a[0], b[0]), min(a[1], b[1])
    return (low, high) if low <= high else EMPTY


def _join(a: Span, b: Span) -> Span:
    return min(a[0], b[0]), max(a[1], b[1])
