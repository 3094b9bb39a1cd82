"""Choose a solver and allocate contact forces."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np

from pivotgait.exceptions import UnknownNameError
from pivotgait.forces.found import Found
from pivotgait.forces.problem import AllocationProblem
from pivotgait.forces.solution import Allocation

Solver = Literal["auto", "interior_point", "clarabel", "cvxpy", "proxqp"]
SOLVERS: tuple[str, ...] = get_args(Solver)[1:]
FEW_SAMPLES = 4
"""Up to this many samples Clarabel, one by one, beats the batched solver's numpy overhead."""


def allocate(problem: AllocationProblem, solver: Solver = "auto") -> Allocation:
    """Allocate contact forces (Xue et al., eqs 4-8).

    Args:
        problem: T samples.
        solver: ``interior_point`` (ours: exact cones, uncoupled samples as one batch),
            ``clarabel`` (exact cones, coupled rows too), ``cvxpy`` (the readable reference),
            ``proxqp`` (an inner pyramid), or ``auto``: Clarabel where samples are coupled or
            few, the batch otherwise.

    Returns:
        The allocation; infeasible samples are marked, see :meth:`Allocation.require`.

    Raises:
        InputError: the solver does not serve this problem; says which does.
        SolverError: the solver ended without an answer or a proof that there is none.
    """
    name: str = solver
    if solver == "auto":
        few = problem.samples <= FEW_SAMPLES and problem.objective in ("tangential", "effort")
        name = "clarabel" if problem.coupled or few else "interior_point"
    answer = Allocation.of(problem, _solver(name)(problem), name)
    if solver == "auto" and problem.objective == "margin" and not answer.converged:
        other = Allocation.of(problem, _solver("clarabel")(problem), "clarabel")
        return _larger_margin(answer, other)
    return answer


def _larger_margin(first: Allocation, second: Allocation) -> Allocation:
    """Sample by sample the answer with the larger margin; the linear programs of ``margin`` can
    stall in either solver, and do so on different samples."""
    better = second.feasible & ~(second.objective <= first.objective)
    force = np.where(better[:, None, None], second.force, first.force)
    iterations = max(first.iterations, second.iterations)
    found = Found(force, first.feasible | second.feasible, iterations, second.converged)
    return Allocation.of(first.problem, found, f"{first.solver} and {second.solver}")


def _solver(name: str) -> Callable[[AllocationProblem], Found]:
    if name == "interior_point":
        from pivotgait.forces.interior_point import solve
    elif name == "clarabel":
        from pivotgait.forces.clarabel_ import solve
    elif name == "cvxpy":
        from pivotgait.forces.cvxpy_ import solve
    elif name == "proxqp":
        from pivotgait.forces.proxqp_ import solve
    else:
        raise UnknownNameError("allocation solver", name, ("auto", *SOLVERS))
    return solve
