"""Smooth objectives of one contact force: value, gradient, Hessian; vectorised.

Forces are in contact coordinates x = (t_x, t_y, n), normal last, on the first axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import InputError

Array = NDArray[np.float64]
SMOOTH = ("alignment", "tangential", "effort")


def value(objective: str, x: Array) -> Array:
    """(...) objective of each force (3, ...); tangential and alignment need n > 0.

    Raises:
        InputError: for an objective that is not a smooth sum over contacts.
    """
    tangent = x[0] ** 2 + x[1] ** 2
    normal = x[2]
    if objective == "effort":
        return np.asarray(tangent + normal**2)
    if objective == "tangential":
        return np.asarray(tangent / normal)
    if objective == "alignment":
        return np.asarray(tangent / (tangent + normal**2))
    raise InputError(f"objective {objective!r} is not smooth", mend=f"known: {', '.join(SMOOTH)}")


def gradient(objective: str, x: Array) -> Array:
    """(3, ...) gradient of :func:`value`."""
    normal = x[2]
    tangent = x[0] ** 2 + x[1] ** 2
    out = np.empty_like(x)
    if objective == "effort":
        np.multiply(x, 2.0, out=out)
    elif objective == "tangential":
        out[:2] = 2.0 * x[:2] / normal
        out[2] = -tangent / normal**2
    else:
        square = tangent + normal**2
        out[:2] = x[:2] * (2.0 * normal**2 / square**2)
        out[2] = -2.0 * tangent * normal / square**2
    return out


def hessian(objective: str, x: Array, *, concave: Array | float = 0.0) -> Array:
    """(3, 3, ...) Hessian of :func:`value`.

    sin^2 of the angle has the Hessian (2 / |f|^2) (cos^2 (I - v v') - sin^2 v v') with the
    unit vector v = (sin 2a t, cos 2a): two equal non-negative curvatures and one that is not.

    Args:
        objective: one of :data:`SMOOTH`.
        x: (3, ...) forces.
        concave: share (...) of alignment's negative curvature to keep: 1 is the exact Hessian,
            0 its positive semidefinite part.
    """
    normal = x[2]
    tangent = x[0] ** 2 + x[1] ** 2
    out = np.zeros((3, *x.shape), dtype=x.dtype)
    if objective == "effort":
        diagonal = np.full_like(normal, 2.0)
        out[2, 2] = diagonal
    elif objective == "tangential":
        diagonal = 2.0 / normal
        slope = x[:2] / normal
        cross = -diagonal * slope
        out[:2, 2] = out[2, :2] = cross
        out[2, 2] = diagonal * tangent / normal**2
    else:
        square = tangent + normal**2
        cos2 = normal**2 / square
        v = np.empty_like(x)
        v[:2] = x[:2] * (2.0 * normal / square)
        v[2] = 2.0 * cos2 - 1.0
        diagonal = 2.0 * cos2 / square
        shrink = diagonal + concave * (2.0 * (1.0 - cos2) / square)
        out -= shrink * v[:, None] * v[None]
        out[2, 2] += diagonal
    out[0, 0] += diagonal
    out[1, 1] += diagonal
    return out
