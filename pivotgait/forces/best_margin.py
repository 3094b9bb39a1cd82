"""The objective ``margin``: the largest smallest friction margin of every problem of a batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import SolverError
from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.phase_one import phase_one
from pivotgait.forces.primal_dual import minimise, require_optimal
from pivotgait.forces.problem import MARGIN_SLACK

Array = NDArray[np.float64]
ROUNDS = 30


def best_margin(cones: ConeBatch, z: Array) -> tuple[Array, int, bool]:
    """Dinkelbach's method on the largest |f_t| / (mu f_n), then ``tangential`` within it.

    Args:
        cones: the constraints.
        z: (d, B) strictly feasible points.

    Returns:
        Points (d, B), Newton steps, and whether every last round proved its margin the best.
    """
    q, d, batch = cones.matrix.shape
    heads = slice(2 * cones.cones, 3 * cones.cones)
    start, best = z, np.array(z)
    ratio = _worst_ratio(cones, z)
    open_ = np.arange(batch)
    gap = np.full(batch, np.inf)
    steps = 0
    for _ in range(ROUNDS):
        part = cones.take(open_)
        at = part.slack(best[:, open_])[heads]
        shrunk = _shrunk(part, ratio[open_])
        column = np.zeros((q, 1, open_.size))
        column[heads, 0] = at
        # A positive shift would let unbounded normal forces turn negative: heads stay positive.
        pressed = np.concatenate((part.matrix[heads], np.zeros_like(column[heads])), axis=1)
        lifted = ConeBatch(
            np.concatenate((np.concatenate((shrunk.matrix, column), axis=1), pressed)),
            np.concatenate((shrunk.offset, part.offset[heads])),
            shrunk.head,
        )
        # From the interior point of phase 1: what its own ratio misses, the shift makes up.
        cone = shrunk.split(shrunk.slack(start[:, open_]))[0]
        need = (-algebra.margin(cone) / at).max(axis=0)
        lift = np.concatenate((start[:, open_], np.maximum(need, 0.0)[None] + 0.1))
        end = minimise(lifted, Goal(linear=np.append(np.zeros(d), 1.0)), lift)
        steps += int(end.iterations.max())
        gap[open_] = end.gap
        new = _worst_ratio(part, end.z[:-1])
        gain = ratio[open_] - new
        better = gain > 0.0
        best[:, open_[better]] = end.z[:-1, better]
        ratio[open_[better]] = new[better]
        open_ = open_[gain > 0.1 * MARGIN_SLACK]
        if open_.size == 0:
            break
    else:
        raise SolverError(
            f"the margin still grows after {ROUNDS} rounds", mend="use solver='clarabel'"
        )
    thin = _shrunk(cones, ratio + MARGIN_SLACK)
    first = phase_one(thin)
    ok = np.nonzero(first.shift < 0.0)[0]
    if ok.size:
        end = minimise(thin.take(ok), Goal(smooth="tangential"), first.z[:, ok])
        require_optimal(end)
        best[:, ok] = end.z
        steps += int(end.iterations.max())
    return best, steps, bool(np.all(gap <= MARGIN_SLACK))


def _worst_ratio(cones: ConeBatch, z: Array) -> Array:
    cone = cones.split(cones.slack(z))[0]
    pressed = np.all(cone[2] > 0.0, axis=0)
    ratio = np.hypot(cone[0], cone[1]) / np.where(pressed, cone[2], 1.0)
    return np.where(pressed, ratio.max(axis=0), np.inf)


def _shrunk(cones: ConeBatch, ratio: Array) -> ConeBatch:
    """The cones with friction times ratio (B,)."""
    matrix, offset = np.array(cones.matrix), np.array(cones.offset)
    heads = slice(2 * cones.cones, 3 * cones.cones)
    matrix[heads] *= ratio
    offset[heads] *= ratio
    return ConeBatch(matrix, offset, cones.head * ratio)
