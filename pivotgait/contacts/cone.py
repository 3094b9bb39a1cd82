"""Coulomb friction cones: the exact second-order cone and an inner pyramid of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def split_force(force: ArrayLike, normal: ArrayLike) -> tuple[Array, Array]:
    """Normal component (...,) and tangential magnitude (...,) of forces [N].

    Args:
        force: (..., 3) forces.
        normal: (..., 3) unit inward normals in the same frame.
    """
    f, n = np.asarray(force, dtype=float), np.asarray(normal, dtype=float)
    normal_force = np.sum(f * n, axis=-1)
    tangential = f - normal_force[..., None] * n
    return normal_force, np.linalg.norm(tangential, axis=-1)


def cone_margin(force: ArrayLike, normal: ArrayLike, friction: ArrayLike) -> Array:
    """Slack of the exact friction cone, mu f_n - |f_t| [N] (Xue et al., eq. 5).

    Non-negative inside the cone. Shapes broadcast; returns (...,).
    """
    normal_force, tangential = split_force(force, normal)
    return np.asarray(np.asarray(friction, dtype=float) * normal_force - tangential)


def friction_margin(force: ArrayLike, normal: ArrayLike, friction: ArrayLike) -> Array:
    """Relative friction margin 1 - |f_t| / (mu f_n), in [0, 1] inside the cone.

    NaN where the normal force is not positive: no force, no margin. Minus infinity where it is
    too small for the quotient to be a number.
    """
    normal_force, tangential = split_force(force, normal)
    limit = np.asarray(friction, dtype=float) * normal_force
    loaded = limit > 0.0
    with np.errstate(over="ignore"):
        return np.where(loaded, 1.0 - tangential / np.where(loaded, limit, 1.0), np.nan)


def inner_pyramid(friction: float, facets: int = 8) -> Array:
    """Rows A with A @ (f_x, f_y, f_n) <= 0 inside a pyramid inscribed in the cone.

    The pyramid's edges lie on the cone, its facets at mu cos(pi / facets), so that every
    point of it satisfies the exact cone (eq. 5). A second-order cone cannot enter a QP.

    Args:
        friction: Coulomb coefficient, > 0.
        facets: number of facets, >= 3.

    Returns:
        (facets, 3) rows in contact-frame coordinates.

    Raises:
        ValueError: for fewer than three facets or friction that is not positive.
    """
    if facets < 3 or not friction > 0.0:
        raise ValueError(
            f"inner_pyramid needs facets >= 3 and friction > 0, got {facets}, {friction}"
        )
    angle = (2.0 * np.arange(facets) + 1.0) * np.pi / facets
    height = np.full(facets, -friction * np.cos(np.pi / facets))
    return np.stack((np.cos(angle), np.sin(angle), height), axis=-1)
