"""Phase 1: strictly feasible points of a cone batch, or the proof that there are none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.primal_dual import minimise

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
FEASIBLE = 1e-9
"""Violations up to this share of the problem's force scale count as feasible."""


@dataclass(frozen=True, eq=False)
class PhaseOne:
    """Smallest common shift that makes every constraint hold.

    Attributes:
        z: (d, B) the point.
        shift: (B,) the shift there, scaled force; negative inside.
        dual: (q, B) multipliers: the share of each constraint in the shift.
        iterations: (B,).
    """

    z: Array
    shift: Array
    dual: Array
    iterations: NDArray[np.intp]


def phase_one(cones: ConeBatch, *, exact: bool = False) -> PhaseOne:
    """Minimise tau with |f_t| <= mu f_n + tau and every scalar slack >= -tau.

    Args:
        cones: the constraints.
        exact: converge fully; otherwise leave once half of the depth is reached inside, or the
            dual bound proves that there is no inside.
    """
    q, d, batch = cones.matrix.shape
    shift = np.ones((q, 1, batch))
    shift[: 2 * cones.cones] = 0.0
    # Without bounds the shift could fall forever; minus ten force scales is deep enough.
    extra = np.zeros((1, d + 1, batch))
    extra[:, -1] = 1.0
    matrix = np.concatenate((np.concatenate((cones.matrix, shift), axis=1), extra))
    offset = np.concatenate((cones.offset, np.full((1, batch), 10.0)))
    lifted = ConeBatch(matrix, offset, cones.head)
    z = np.zeros((d + 1, batch))
    z[-1] = 1.0 - np.minimum(cones.interior(cones.offset), 0.0)

    def stop(shift: Array, gap: Array, residual: Array) -> Mask:
        inside = (shift < -1e-3 * FEASIBLE) & (gap <= np.abs(shift)) & (residual <= 0.1)
        return np.asarray(inside | ((shift - gap > FEASIBLE) & (residual <= 1e-9)))

    goal = Goal(linear=np.append(np.zeros(d), 1.0))
    end = minimise(lifted, goal, z, stop=None if exact else stop)
    return PhaseOne(end.z[:-1], end.z[-1], end.dual[:-1], end.iterations)
