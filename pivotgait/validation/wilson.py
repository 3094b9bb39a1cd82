"""Confidence of a success rate."""

from __future__ import annotations

from math import sqrt

Z_95 = 1.959963984540054
"""Quantile of the normal distribution for a two-sided confidence of 95 %."""


def wilson_interval(passed: int, trials: int, z: float = Z_95) -> tuple[float, float]:
    """Wilson's score interval of a rate; (0, 1) without trials.

    Unlike the normal approximation it stays within [0, 1] and does not shrink to nothing where
    all trials pass.

    Raises:
        ValueError: unless 0 <= passed <= trials.
    """
    if not 0 <= passed <= trials:
        raise ValueError(f"{passed} of {trials} trials")
    if trials == 0:
        return 0.0, 1.0
    rate, square = passed / trials, z * z / trials
    centre = (rate + 0.5 * square) / (1.0 + square)
    half = z * sqrt(rate * (1.0 - rate) / trials + 0.25 * square / trials) / (1.0 + square)
    return max(centre - half, 0.0), min(centre + half, 1.0)
