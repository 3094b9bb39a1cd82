"""The objective ``margin``: the largest smallest friction margin of every problem of a batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.phase_one import phase_one
from pivotgait.forces.primal_dual import minimise
from pivotgait.forces.problem import MARGIN_SLACK

Array = NDArray[np.float64]


def best_margin(cones: ConeBatch, z: Array) -> tuple[Array, int]:
    """Dinkelbach's method on the largest |f_t| / (mu f_n), then ``tangential`` within it."""
    batch, q, d = cones.matrix.shape
    c3 = 3 * cones.cones
    start, best = z, z
    ratio = _worst_ratio(cones, z)
    open_ = np.arange(batch)
    steps = 0
    for _ in range(30):
        part = cones.take(open_)
        at = part.split(part.slack(best[open_]))[0][..., 2]
        lifted = _shrunk(part, ratio[open_])
        column = np.zeros((len(open_), q, 1))
        column[:, 2:c3:3, 0] = at
        lifted = ConeBatch(
            np.concatenate((lifted.matrix, column), axis=2), lifted.offset, lifted.head
        )
        # From the interior point of phase 1: what its own ratio misses, the shift makes up.
        cone = lifted.split(
            lifted.offset + (lifted.matrix[..., :-1] @ start[open_][..., None])[..., 0]
        )[0]
        need = (-algebra.margin(cone) / at).max(axis=1)
        lift = np.column_stack((start[open_], np.maximum(need, 0.0) + 0.1))
        end = minimise(lifted, Goal(linear=np.append(np.zeros(d), 1.0)), lift)
        steps += int(end.iterations.max())
        new = _worst_ratio(part, end.z[:, :-1])
        gain = ratio[open_] - new
        better = gain > 0.0
        best[open_[better]] = end.z[better, :-1]
        ratio[open_[better]] = new[better]
        open_ = open_[gain > 0.1 * MARGIN_SLACK]
        if open_.size == 0:
            break
    thin = _shrunk(cones, ratio + MARGIN_SLACK)
    inside = phase_one(thin)
    ok = np.nonzero(inside.shift < 0.0)[0]
    if ok.size:
        end = minimise(thin.take(ok), Goal(smooth="tangential"), inside.z[ok])
        best[ok] = end.z
        steps += int(end.iterations.max())
    return best, steps


def _worst_ratio(cones: ConeBatch, z: Array) -> Array:
    cone = cones.split(cones.slack(z))[0]
    return np.asarray((np.hypot(cone[..., 0], cone[..., 1]) / cone[..., 2]).max(axis=1))


def _shrunk(cones: ConeBatch, ratio: Array) -> ConeBatch:
    """The cones with friction times ratio (B,)."""
    matrix, offset = np.array(cones.matrix), np.array(cones.offset)
    heads = slice(2, 3 * cones.cones, 3)
    matrix[:, heads] *= ratio[:, None, None]
    offset[:, heads] *= ratio[:, None]
    return ConeBatch(matrix, offset, cones.head * ratio[:, None])
