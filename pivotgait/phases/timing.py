"""Timing laws: path fraction s(t) from 0 to 1 with its two time derivatives, analytic."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Profile = Literal["quintic", "trapezoidal"]


def quintic(time: Array, duration: float) -> tuple[Array, Array, Array]:
    """Minimum-jerk timing: C2, at rest with zero acceleration at both ends.

    Args:
        time: (N,) within [0, duration] [s].
        duration: [s].

    Returns:
        Fraction [-], its rate [1/s] and acceleration [1/s^2], each (N,).
    """
    u = np.asarray(time, dtype=float) / duration
    fraction = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    rate = 30.0 * u**2 * (1.0 - u) ** 2 / duration
    acceleration = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / duration**2
    return fraction, rate, acceleration


def trapezoidal(
    time: Array, duration: float, ramp_share: float = 0.25
) -> tuple[Array, Array, Array]:
    """Trapezoidal velocity, as in Section III: constant acceleration, cruise, deceleration.

    The acceleration jumps, and so do the forces that follow from it. At a jump the value
    after it is returned, at the end the value before it, and both ends count as at rest
    (zero acceleration), so that phases join.

    Args:
        time: (N,) within [0, duration] [s].
        duration: [s].
        ramp_share: share of the duration spent accelerating, and again decelerating.

    Returns:
        As :func:`quintic`.
    """
    t = np.asarray(time, dtype=float)
    ramp = ramp_share * duration
    cruise = 1.0 / (duration - ramp)
    slope = cruise / ramp
    left = duration - t
    fraction = np.where(
        t < ramp,
        0.5 * slope * t**2,
        np.where(left > ramp, cruise * (t - 0.5 * ramp), 1.0 - 0.5 * slope * left**2),
    )
    rate = np.where(t < ramp, slope * t, np.where(left > ramp, cruise, slope * left))
    edge = 1e-9 * duration
    acceleration = np.where(t < ramp - edge, slope, np.where(left > ramp + edge, 0.0, -slope))
    acceleration[(t <= edge) | (left <= edge)] = 0.0
    return fraction, rate, acceleration


PROFILES = {"quintic": quintic, "trapezoidal": trapezoidal}
