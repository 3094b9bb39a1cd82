r"""Whether joint positions, speeds and accelerations tell one story over time.

Samples q_k, v_k, a_k at times t_k, steps h_k. A motion whose acceleration is continuous, or jumps
within a step from a to b, obeys the trapezoid rule as derived in ``sampling.py``:
q_{k+1} - q_k is off by at most h^2 |a - b| / 8, and v_{k+1} - v_k by at most h |a - b| / 2, with
|a - b| the largest change of the samples over a step and its two neighbours. Cubic pieces are off
by h^2 |da| / 12 and by nothing, quintic ones by less than the allowance once a few steps resolve
them.

While fingers hold a tool that turns by **forward Euler** (removal), q_k = Q(r_k) for a smooth Q.
Along a step the tool turns steadily, hence q_{k+1} - q_k = h v_k + h^2 b / 2 with b the joints'
acceleration at steady turning, and a_k = b + Q' s_k. The trapezoid rule is then off by
h^2 |Q' s| / 2, also where s is constant, and |Q' s| <= |a| + |b|; b is not stored, but no larger
than the accelerations it is part of: in such a phase h^2 max |a| over the phase is allowed on top.
The speeds obey Euler's rule v_{k+1} - v_k = h a_k + h^2 (dQ'/dt) s_k + ..., whose distance from the
trapezoid rule is h |da| / 2 and twice the second term. That term is part of da as well, but may
cancel against the change of s there; it does not all along the phase, so that h max |da| over the
phase is allowed. What hides below these in the motion of holding fingers is seen at their contacts,
whose positions, speeds and accelerations are checked by themselves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pivotgait.certification.certificate import Finding, largest_joint
from pivotgait.certification.sampling import is_forward_euler
from pivotgait.frozen import Array
from pivotgait.plans import Phase, RobotMotion

_ROUNDING = 1.0 + 1e-6


def check_joint_sampling(
    phase: Phase, motion: RobotMotion, names: Sequence[str]
) -> Iterator[Finding]:
    """Excess of the joints' steps over what finite sampling allows."""
    h = np.diff(phase.time)[:, None]
    q, v, a = motion.q, motion.v, motion.a
    jump = _with_neighbours(np.abs(np.diff(a, axis=0)))
    step_allowed, rate_allowed = h**2 * jump / 8.0, 0.5 * h * jump
    if is_forward_euler(phase):
        step_allowed = step_allowed + h**2 * np.max(np.abs(a), axis=0)
        rate_allowed = rate_allowed + h * np.max(jump, axis=0)
    step_error = np.abs(np.diff(q, axis=0) - 0.5 * h * (v[:-1] + v[1:]))
    rate_error = np.abs(np.diff(v, axis=0) - 0.5 * h * (a[:-1] + a[1:]))
    step_excess = np.maximum(step_error - step_allowed * _ROUNDING, 0.0)
    rate_excess = np.maximum(rate_error - rate_allowed * _ROUNDING, 0.0)
    yield largest_joint("joint_step_excess", step_excess, phase, names)
    yield largest_joint("joint_rate_excess", rate_excess, phase, names)


def _with_neighbours(values: Array) -> Array:
    padded = np.pad(values, ((1, 1), (0, 0)), mode="edge")
    return np.asarray(padded[:-2] + padded[1:-1] + padded[2:])
