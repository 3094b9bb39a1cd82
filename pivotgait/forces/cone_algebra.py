"""Second-order cone algebra on batches of 3-vectors (t_x, t_y, head): head >= |t|.

The vector's components are the first axis, so that every operation runs along memory.

Notation of Andersen, Roos and Terlaky, "On implementing a primal-dual interior-point method
for conic quadratic optimization", Math. Program. 2003, with the head last.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def margin(s: Array) -> Array:
    """Head minus tangential length (...), positive inside."""
    return np.asarray(s[2] - _length(s))


def determinant(s: Array) -> Array:
    """head^2 - |t|^2 (...), as a product: the difference of squares loses digits at the edge."""
    length = _length(s)
    return np.asarray((s[2] - length) * (s[2] + length))


def _length(s: Array) -> Array:
    return np.asarray(np.sqrt(s[0] * s[0] + s[1] * s[1]))


def reflect(s: Array) -> Array:
    """J s: the tangential part with its sign changed."""
    out = -s
    out[2] = s[2]
    return out


def scaling(s: Array, dual: Array, det_s: Array, det_dual: Array) -> tuple[Array, Array]:
    """Nesterov-Todd scaling W, as the inverse W^-1 = factor R(w): W^-1 s = W dual.

    R(w) is the symmetric matrix whose square is 2 w w' - J, see :func:`scale`.

    Args:
        s: (3, ...) interior slack.
        dual: (3, ...) interior dual.
        det_s: (...) determinant of s.
        det_dual: (...) determinant of the dual.

    Returns:
        w (3, ...) of unit determinant and factor (...).
    """
    root_s, root_dual = np.sqrt(det_s), np.sqrt(det_dual)
    unit_s, unit_dual = s / root_s, dual / root_dual
    gamma2 = 0.5 * (1.0 + np.sum(unit_s * unit_dual, axis=0))
    w = (reflect(unit_s) + unit_dual) / (2.0 * np.sqrt(gamma2))
    return w, np.sqrt(root_dual / root_s)


def scale(w: Array, factor: Array, x: Array) -> Array:
    """factor R(w) x (3, ...) with R(w) = [[I + t t' / (1 + h), t], [t', h]] for w = (t, h)."""
    dot = w[0] * x[0] + w[1] * x[1]
    along = x[2] + dot / (1.0 + w[2])
    out = np.empty_like(x)
    out[:2] = x[:2] + w[:2] * along
    out[2] = dot + w[2] * x[2]
    out *= factor
    return out


def squared(w: Array, factor: Array) -> Array:
    """W^-2 (3, 3, ...), which maps s to its dual: factor^2 (2 w w' - J)."""
    out = 2.0 * w[:, None] * w[None]
    out[0, 0] += 1.0
    out[1, 1] += 1.0
    out[2, 2] -= 1.0
    out *= factor**2
    return np.asarray(out)


def product(a: Array, b: Array) -> Array:
    """Jordan product (3, ...): head a . b, tangential part a_h b_t + b_h a_t."""
    out = np.empty_like(a)
    out[:2] = a[2] * b[:2] + b[2] * a[:2]
    out[2] = np.sum(a * b, axis=0)
    return out


def divide(c: Array, a: Array) -> Array:
    """The x (3, ...) whose Jordan product with a is c."""
    out = np.empty_like(a)
    dot = a[0] * c[0] + a[1] * c[1]
    out[2] = (a[2] * c[2] - dot) / determinant(a)
    out[:2] = (c[:2] - out[2] * a[:2]) / a[2]
    return out


def shrink(s: Array, ds: Array, det_s: Array) -> Array:
    """One over the largest step (...) with s + step ds in the cone; at most 0 if unbounded.

    The step is the smallest positive root of det(s + step ds) = a step^2 + 2 b step + c.
    """
    a = ds[2] ** 2 - ds[0] ** 2 - ds[1] ** 2
    b = s[2] * ds[2] - s[0] * ds[0] - s[1] * ds[1]
    square = b * b - a * det_s
    return np.where(square > 0.0, np.sqrt(np.maximum(square, 0.0)) - b, 0.0) / det_s
