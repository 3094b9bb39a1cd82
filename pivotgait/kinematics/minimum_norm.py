"""Minimum-norm solutions of small wide linear systems, at LAPACK's own speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import lstsq
from scipy.linalg.lapack import dgels

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array

RANK_TOLERANCE = 1e-10
"""Ratio of pivots (or singular values) below which a system counts as rank deficient."""


def mobility(weights: Array | None, fixed: Sequence[int], size: int) -> Array:
    """(size,) square roots of the inverse weights: 0 for a joint that stays.

    Args:
        weights: (size,) positive diagonal of the metric W, infinite for a joint that stays;
            ones if not given.
        fixed: columns of further joints that stay.
        size: number of joints.

    Raises:
        InputError: for weights that are not positive numbers or not ``size`` of them.
    """
    if weights is None:
        scale = np.ones(size)
    else:
        if weights.shape != (size,) or not np.all(weights > 0.0):
            raise InputError(f"joint weights {weights}", mend=f"give {size} positive numbers")
        scale = 1.0 / np.sqrt(weights)
    if fixed:
        scale[list(fixed)] = 0.0
    return scale


def minimum_norm(matrix: Array, right: Array, scale: Array) -> Array:
    """x = argmin x^T W x subject to ``matrix`` x = ``right``, with W = diag(1 / scale^2).

    By the QR factors of the transpose, which do not square the condition number as the normal
    equations do. If the rows contradict or repeat one another, the pseudo-inverse's answer:
    the least squares of the rows, and the least norm among those.

    Args:
        matrix: (m, n).
        right: (m,).
        scale: (n,) of :func:`mobility`.

    Returns:
        (n,).
    """
    rows, columns = matrix.shape
    if rows == 0:
        return np.zeros(columns)
    scaled = matrix * scale
    padded = np.zeros(max(rows, columns))
    padded[:rows] = right
    # The transpose of a C-ordered array is Fortran's own order: no copy.
    factors, solution, _ = dgels(scaled.T, padded, trans="T")
    pivots = np.abs(factors.diagonal()).tolist()
    if not min(pivots) > RANK_TOLERANCE * max(pivots):
        solution = lstsq(scaled, right, cond=RANK_TOLERANCE, check_finite=False)[0]
    return np.asarray(scale * solution[:columns])
