"""Cholesky factors of many small matrices at once, the batch on the last axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Cholesky:
    """L D L' of B symmetric matrices, given by their lower triangles.

    Attributes:
        positive: (B,) whether the matrix is positive definite; where not, solutions mean
            nothing.
    """

    def __init__(self, matrix: Array) -> None:
        """Factorise matrix (d, d, B); it is not changed."""
        lower = np.array(matrix)
        self.positive = np.ones(matrix.shape[-1], dtype=bool)
        for k in range(len(lower)):
            self.positive &= lower[k, k] > 0.0
            lower[k, k] = np.where(self.positive, lower[k, k], 1.0)
            below = np.where(self.positive, lower[k + 1 :, k], 0.0)
            lower[k + 1 :, k] = below / lower[k, k]
            for j in range(k + 1, len(lower)):
                lower[j, k + 1 : j + 1] -= lower[j, k] * below[: j - k]
        self._lower = lower

    def solve(self, side: Array) -> Array:
        """(d, B) solutions for right-hand sides (d, B)."""
        x, lower = np.array(side), self._lower
        for k in range(len(x) - 1):
            x[k + 1 :] -= lower[k + 1 :, k] * x[k]
        for k in range(len(x)):
            x[k] /= lower[k, k]
        for k in range(len(x) - 1, 0, -1):
            x[:k] -= lower[k, :k] * x[k]
        return x
