"""Joint accelerations nearest to wanted ones within limits: a dense quadratic program, ProxQP."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.forces.proxqp_build import load_proxqp
from pivotgait.frozen import Array

EPS = 1e-6
"""Absolute residual asked of ProxQP, on accelerations in units of their own limits."""
MAX_ITERATIONS = 200


class ResolutionQp:
    """min 1/2 x^T P x + g^T x subject to lower <= C x <= upper, of one size, warm started.

    Attributes:
        size: number of unknowns.
        rows: number of rows of C.
    """

    def __init__(self, size: int, rows: int) -> None:
        """A program without an answer to start from."""
        self.size, self.rows = size, rows
        self._program: Any = None

    def reset(self) -> None:
        """Forget the last answer, from which the next solve would start."""
        self._program = None

    def solve(
        self, hessian: Array, slope: Array, matrix: Array, lower: Array, upper: Array
    ) -> Array | None:
        """(size,) x, or None where ProxQP found no point within the limits.

        Args:
            hessian: (size, size) P, positive definite.
            slope: (size,) g.
            matrix: (rows, size) C.
            lower: (rows,).
            upper: (rows,), nowhere below ``lower``.
        """
        warm = self._program is not None
        found = self._attempt(hessian, slope, matrix, lower, upper)
        if found is None and warm:
            # The last answer may lead astray where the program has changed much.
            found = self._attempt(hessian, slope, matrix, lower, upper)
        return found

    def _attempt(self, *given: Array) -> Array | None:
        """(size,) x, or None, after which the next attempt starts afresh."""
        hessian, slope, *rows = given
        proxqp = load_proxqp()
        if self._program is None:
            self._program = proxqp.dense.QP(self.size, 0, self.rows)
            settings = self._program.settings
            settings.eps_abs, settings.eps_rel = EPS, 0.0
            settings.max_iter = MAX_ITERATIONS
            settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            self._program.init(hessian, slope, None, None, *rows)
        else:
            self._program.update(hessian, slope, None, None, *rows)
        self._program.solve()
        results = self._program.results
        found = np.array(results.x)
        solved = results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        if solved and np.isfinite(found).all():
            return found
        self.reset()
        return None
