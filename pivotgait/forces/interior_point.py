"""Our batched solver: exact friction cones, all samples of an uncoupled problem at once.

Phase 1 finds strictly feasible forces or proves that there are none; phase 2 minimises.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import InputError
from pivotgait.forces.best_alignment import best_alignment
from pivotgait.forces.best_margin import best_margin
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.found import Found
from pivotgait.forces.goal import Goal
from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.null_space import Inconsistent, Reduced, reduce
from pivotgait.forces.phase_one import FEASIBLE, phase_one
from pivotgait.forces.primal_dual import minimise, require_optimal
from pivotgait.forces.problem import AllocationProblem

Array = NDArray[np.float64]


def solve(problem: AllocationProblem) -> Found:
    """Forces and the Newton steps of the slowest sample.

    Raises:
        InputError: for a coupled problem.
        SolverError: a sample stalled short of its optimum.
    """
    if problem.coupled:
        raise InputError(
            "the interior point solver takes uncoupled samples", mend="use solver='clarabel'"
        )
    form = local_form(problem)
    friction = np.broadcast_to(problem.friction, (problem.samples, problem.contacts))
    return solve_form(form, problem.wrench, friction, problem.objective)


def solve_form(form: LocalForm, wrench: Array, friction: Array, objective: str) -> Found:
    """As :func:`solve`, with the friction (T, m) of each sample."""
    x = np.full(form.value.shape, np.nan)
    steps, converged = 0, True
    for group in reduce(form, wrench, friction):
        if isinstance(group, Inconsistent):
            continue
        first = phase_one(group.cones)
        steps = max(steps, int(first.iterations.max()))
        x[group.index] = np.where(
            (first.shift <= FEASIBLE)[:, None, None], group.forces(first.z), np.nan
        )
        # Without an interior (or unknowns) the point of phase 1 is the answer.
        inner = np.nonzero(first.shift < -1e-3 * FEASIBLE)[0]
        if inner.size and group.basis.shape[2]:
            z, used, proven = _best(group.cones.take(inner), objective, first.z[:, inner])
            x[group.index[inner]] = _part(group, inner).forces(z)
            steps, converged = max(steps, used), converged and proven
    force = form.world(x)
    return Found(force, np.isfinite(x).all(axis=(1, 2)), steps, converged)


def _part(group: Reduced, keep: NDArray[np.intp]) -> Reduced:
    return Reduced(
        group.index[keep],
        group.scale[keep],
        group.origin[keep],
        group.basis[keep],
        group.cones.take(keep),
        group.labels,
        group.loaded,
    )


def _best(cones: ConeBatch, objective: str, z: Array) -> tuple[Array, int, bool]:
    if objective == "margin":
        return best_margin(cones, z)
    if objective == "alignment":
        return *best_alignment(cones, z), True
    end = minimise(cones, Goal(smooth=objective), z)
    require_optimal(end)
    return end.z, int(end.iterations.max()), True
