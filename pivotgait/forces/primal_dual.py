"""A feasible primal-dual interior-point method, vectorised over small conic problems.

Minimises a :class:`Goal` subject to K z + k in the cones, from strictly feasible points. The
line search on the barrier function makes the non-convex alignment (Xue et al., eq. 4) safe.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import SolverError
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.newton_step import advance

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
ITERATION_LIMIT = 80
GAP_TOLERANCE = 1e-9
"""Complementarity over the objective's size: leaves objectives right to about nine digits."""
GRADIENT_TOLERANCE = 1e-8
"""Dual residual over the gradient's size; forces are scaled to about one."""

ACCEPTED = 1e-6
"""A gap that stalls above this share of the objective is an error, not an answer."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """State of the B problems.

    Attributes:
        z: (d, B) point.
        dual: (q, B) multipliers of the slacks.
        value: (B,) goal.
        gap: (B,) complementarity s . dual.
        converged: (B,) whether the tolerances (or the caller's stop) were met.
        iterations: (B,) Newton steps.
    """

    z: Array
    dual: Array
    value: Array
    gap: Array
    converged: Mask
    iterations: NDArray[np.intp]


Stop = Callable[[Array, Array, Array], Mask]


def minimise(
    cones: ConeBatch,
    goal: Goal,
    z: Array,
    *,
    dual: Array | None = None,
    stop: Stop | None = None,
    limit: int = ITERATION_LIMIT,
) -> Iterate:
    """Minimise from strictly feasible points.

    Args:
        cones: the constraints.
        goal: the objective.
        z: (d, B) strictly feasible points.
        dual: (q, B) duals to go on from, or None; those that are not interior are replaced.
        stop: (value, gap, residual) -> (B,) whether a problem may leave early.
        limit: most Newton steps.
    """
    q, count = cones.offset.shape
    end = Iterate(
        z=np.array(z),
        dual=np.zeros((q, count), dtype=z.dtype),
        value=np.full(count, np.inf),
        gap=np.full(count, np.inf),
        converged=np.zeros(count, dtype=bool),
        iterations=np.zeros(count, dtype=np.intp),
    )
    active = np.arange(count)
    s = cones.slack(z)
    fresh = _first_dual(cones, goal, s)
    dual = fresh if dual is None else np.where(cones.inside(dual), dual, fresh)
    for iteration in range(limit + 1):
        slope = goal.slope(cones, s)
        residual = np.abs(slope - cones.transposed(dual)).max(axis=0, initial=0.0)
        residual /= 1.0 + np.abs(slope).max(axis=0, initial=0.0)
        gap = np.sum(s * dual, axis=0)
        value = goal.value(cones, z, s)
        target = GAP_TOLERANCE * np.maximum(np.abs(value), goal.unit)
        done = (gap <= target) & (residual <= GRADIENT_TOLERANCE)
        if stop is not None:
            done |= stop(value, gap, residual)
        # Rounding may push a nearly converged dual out of its cone: nothing is left to gain.
        leave = done | ~(cones.inside(s) & cones.inside(dual))
        if iteration == limit:
            leave[:] = True
        if leave.any():
            out = active[leave]
            end.z[:, out], end.dual[:, out] = z[:, leave], dual[:, leave]
            end.value[out] = value[leave]
            end.gap[out], end.iterations[out] = gap[leave], iteration
            end.converged[out] = done[leave]
            stay = np.nonzero(~leave)[0]
            if stay.size == 0:
                break
            active, cones, goal = active[stay], cones.take(stay), goal.take(stay)
            z, s, dual, slope = z[:, stay], s[:, stay], dual[:, stay], slope[:, stay]
            value, gap = value[stay], gap[stay]
            residual, target = residual[stay], target[stay]
        # Complementarity must not run ahead of the dual residual, nor fall below its goal.
        floor = np.minimum(0.1 * np.maximum(target, residual), gap) / cones.degree
        z, s, dual = advance(cones, goal, z, s, dual, value, slope, gap, floor)
    return end


def require_optimal(end: Iterate, accepted: float = ACCEPTED) -> None:
    """Refuse points whose gap exceeds a share of the objective.

    Raises:
        SolverError: the steps ran out or the method stalled.
    """
    if not np.all(end.gap <= accepted * np.maximum(np.abs(end.value), 1.0)):
        raise SolverError("the interior point method stalled", mend="use solver='clarabel'")


def _first_dual(cones: ConeBatch, goal: Goal, s: Array) -> Array:
    """Duals on the central path of the barrier weight that matches the gradient's size."""
    inverse = cones.inverse(s)
    push = np.linalg.norm(cones.transposed(inverse), axis=0)
    weight = np.linalg.norm(goal.slope(cones, s), axis=0) / np.maximum(push, 1e-6)
    return np.asarray(np.clip(weight, 1e-2, 1e2) * inverse)
