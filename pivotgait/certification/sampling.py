r"""Whether orientation, angular velocity and angular acceleration tell one story over time.

Samples r_k, w_k, s_k = w'_k at times t_k, steps h_k. With d_k = log(r_{k+1} r_k^-1), the rotation
vector of a step in the world frame, two kinds of phases must pass:

* **Forward Euler** (finger removal, Section IV-A): r_{k+1} = exp(h w_k / 2) r_k and
  w_{k+1} = w_k + h s_k, so that d_k = h w_k and w_{k+1} - w_k = h s_k hold exactly.
* **Samples of a continuous motion** (lift): trapezoid rule,
  d_k ~ h (w_k + w_{k+1}) / 2 and w_{k+1} - w_k ~ h (s_k + s_{k+1}) / 2. Let the acceleration jump
  from a to b at the fraction f of a step, as a trapezoidal velocity profile has it. Then the first
  is off by h^2 f (1 - f) |a - b| / 2 <= h^2 |a - b| / 8 and the second by
  h |f - 1/2| |a - b| <= h |a - b| / 2. A smooth acceleration is off by h^2 |ds| / 12 and less.
  |a - b| is taken as the largest change of the samples s over a step and its two neighbours, since
  next to an extremum of s the change over the one step may vanish. An axis that turns adds the
  second Magnus term, h^3 |s x w| / 12, allowed here with |s| |w| and twice over.

A phase must obey one of the two rules in all its steps. What remains beyond the allowance is the
excess. Either rule alone would be wrong: Euler's rotations differ from the trapezoid rule by
h^2 |s| / 2 even where s is constant, and a tolerance wide enough for both (|s| for |ds|) would let
a lift be wrong by as much in every step.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.certification.certificate import Finding, largest
from pivotgait.certification.limits import LIMITS
from pivotgait.frozen import Array
from pivotgait.plans import Phase

_ROUNDING = 1.0 + 1e-6


def check_sampling(phase: Phase) -> Iterator[Finding]:
    """Excess of the phase's steps over the better of the two rules."""
    candidates = (_euler_excess(phase), _continuous_excess(phase))
    turn, rate = min(candidates, key=lambda pair: float(np.max(pair[0]) + np.max(pair[1])))
    yield largest("rotation_excess_rad", turn, phase)
    yield largest("rate_excess_rad_s", rate, phase)


def is_forward_euler(phase: Phase) -> bool:
    """Whether the tool turns by Euler's rule and cannot pass for a continuous motion."""
    euler = float(np.max(_euler_excess(phase)[0]))
    continuous = float(np.max(_continuous_excess(phase)[0]))
    return euler < continuous and not LIMITS["rotation_excess_rad"].holds(continuous)


def _euler_excess(phase: Phase) -> tuple[Array, Array]:
    step, turn, change = _steps(phase)
    omega, sigma = phase.tool.angular_velocity, phase.tool.angular_acceleration
    return _length(turn - step * omega[:-1]), _length(change - step * sigma[:-1])


def _continuous_excess(phase: Phase) -> tuple[Array, Array]:
    step, turn, change = _steps(phase)
    omega, sigma = phase.tool.angular_velocity, phase.tool.angular_acceleration
    h = step[:, 0]
    jump = _with_neighbours(_length(np.diff(sigma, axis=0)))
    speed, surge = _length(omega), _length(sigma)
    magnus = np.maximum(speed[:-1], speed[1:]) * np.maximum(surge[:-1], surge[1:])
    turn_error = _length(turn - 0.5 * step * (omega[:-1] + omega[1:]))
    rate_error = _length(change - 0.5 * step * (sigma[:-1] + sigma[1:]))
    turn_allowed = (h**2 * jump / 8.0 + h**3 * magnus / 6.0) * _ROUNDING
    rate_allowed = 0.5 * h * jump * _ROUNDING
    return np.maximum(turn_error - turn_allowed, 0.0), np.maximum(rate_error - rate_allowed, 0.0)


def _steps(phase: Phase) -> tuple[Array, Array, Array]:
    """Durations (K, 1) [s], rotation vectors (K, 3) [rad], changes of omega (K, 3) [rad/s]."""
    rotation = phase.tool.rotation
    turn = (rotation[1:] * rotation[:-1].inv()).as_rotvec()
    return np.diff(phase.time)[:, None], turn, np.diff(phase.tool.angular_velocity, axis=0)


def _length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _with_neighbours(values: Array) -> Array:
    padded = np.pad(values, 1, mode="edge")
    return np.maximum(np.maximum(padded[:-2], padded[2:]), values)
