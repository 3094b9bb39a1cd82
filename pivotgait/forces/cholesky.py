"""Cholesky factors of many small matrices at once, the batch on the last axis."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

Array = NDArray[np.float64]
FEW = 40
"""Up to this many matrices LAPACK, one by one, beats numpy's overhead."""


class Cholesky:
    """L D L' of B symmetric matrices, given by their lower triangles.

    Attributes:
        positive: (B,) whether the matrix is positive definite; where not, solutions mean
            nothing.
    """

    def __init__(self, matrix: Array, *, few: bool = True) -> None:
        """Factorise matrix (d, d, B); it is not changed.

        Args:
            matrix: only its lower triangles are read.
            few: let LAPACK do small batches of positive definite matrices, one by one.
        """
        d, _, batch = matrix.shape
        self._factors: list[Any] = []
        if few and batch <= FEW:
            factors = [lapack.dpotrf(matrix[..., b], lower=1) for b in range(batch)]
            if all(info == 0 for _, info in factors):
                self._factors = [factor for factor, _ in factors]
                self.positive = np.ones(batch, dtype=bool)
                return
        lower = np.array(matrix)
        self.positive = np.ones(batch, dtype=bool)
        for k in range(d):
            self.positive &= lower[k, k] > 0.0
            if not self.positive.all():
                lower[k, k] = np.where(self.positive, lower[k, k], 1.0)
                lower[k + 1 :, k] = np.where(self.positive, lower[k + 1 :, k], 0.0)
            below = np.array(lower[k + 1 :, k])
            lower[k + 1 :, k] /= lower[k, k]
            for j in range(k + 1, d):
                lower[j, k + 1 : j + 1] -= lower[j, k] * below[: j - k]
        self._lower = lower

    def replace(self, index: NDArray[np.intp], matrix: Array) -> None:
        """Factorise other matrices (d, d, len(index)) where not all were positive definite."""
        other = Cholesky(matrix, few=False)
        self.positive[index] = other.positive
        self._lower[..., index] = other._lower

    def solve(self, side: Array) -> Array:
        """(d, ..., B) solutions for right-hand sides (d, ..., B)."""
        x = np.array(side)
        if self._factors:
            for b, factor in enumerate(self._factors):
                x[..., b] = lapack.dpotrs(factor, side[..., b], lower=1)[0]
            return x
        lower = self._lower.reshape(*self._lower.shape[:2], *(1,) * (side.ndim - 2), -1)
        for k in range(len(x) - 1):
            x[k + 1 :] -= lower[k + 1 :, k] * x[k]
        for k in range(len(x)):
            x[k] /= lower[k, k]
        for k in range(len(x) - 1, 0, -1):
            x[:k] -= lower[k, :k] * x[k]
        return x
