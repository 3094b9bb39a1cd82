"""Curves through samples, many channels at once, with their first two derivatives."""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from pivotgait.frozen import Array, frozen

DEGREE = 5


def quintic_spline(time: Array, values: Array, rates: Array, accelerations: Array) -> Array:
    """Coefficients of the C4 spline of degree 5 through samples.

    Args:
        time: (N,) increasing [s], N > 1.
        values: (N, C) samples.
        rates: (N, C) first derivatives; those at both ends are used.
        accelerations: (N, C) second derivatives; those at both ends are used.

    Returns:
        (N - 1, 6, C) coefficients in powers of the time since the step's start, low ones first.
    """
    ends: Any = [[(1, rates[k]), (2, accelerations[k])] for k in (0, -1)]
    spline = make_interp_spline(time, values, k=DEGREE, bc_type=(ends[0], ends[1]))
    starts = np.asarray(time, dtype=float)[:-1]
    powers = [spline(starts, nu=order) / factorial(order) for order in range(DEGREE + 1)]
    return np.stack(powers, axis=1)


def polygon(time: Array, values: Array) -> Array:
    """Coefficients of straight lines between samples, shaped as in :func:`quintic_spline`."""
    coefficients = np.zeros((len(time) - 1, DEGREE + 1, values.shape[1]))
    coefficients[:, 0] = values[:-1]
    coefficients[:, 1] = np.diff(values, axis=0) / np.diff(time)[:, None]
    return coefficients


class Curves:
    """Piecewise polynomials of one time, evaluated together.

    Attributes:
        duration: of the time they cover [s].
    """

    def __init__(self, time: Array, *coefficients: Array) -> None:
        """Curves over ``time`` (N,) [s], which is counted from its first entry.

        Args:
            time: increasing.
            coefficients: (N - 1, 6, C_i) each; the channels of all of them are joined.
        """
        starts = frozen(time - time[0])
        self.duration = float(starts[-1])
        self._starts = starts
        self._times: list[float] = starts.tolist()
        self._last = len(starts) - 2
        self._coefficients = np.concatenate(coefficients, axis=2)
        self._powers = np.zeros((3, DEGREE + 1))
        self._powers[0, 0] = self._powers[1, 1] = 1.0
        self._powers[2, 2] = 2.0

    def __call__(self, time: float) -> Array:
        """(3, C) values, first and second derivatives at ``time``, held within the curves' span."""
        t = min(max(time, 0.0), self.duration)
        step = min(max(int(self._starts.searchsorted(t, side="right")) - 1, 0), self._last)
        s = t - self._times[step]
        s2 = s * s
        s3 = s2 * s
        powers = self._powers
        powers[0, 1:] = s, s2, s3, s2 * s2, s2 * s3
        powers[1, 2:] = 2.0 * s, 3.0 * s2, 4.0 * s3, 5.0 * s2 * s2
        powers[2, 3:] = 6.0 * s, 12.0 * s2, 20.0 * s3
        values: Array = powers.dot(self._coefficients[step])
        return values
