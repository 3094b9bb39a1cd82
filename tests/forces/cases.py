"""Problems and laws that the tests of every solver share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.forces import AllocationProblem

COUNT = {"interior_point": 40, "clarabel": 8, "cvxpy": 2, "proxqp": 4}


def problem_for(solver: str, objective: str, contacts: int = 4, seed: int = 3) -> AllocationProblem:
    rng = np.random.default_rng(seed)
    return random_problem(rng, COUNT[solver], contacts, objective)


def head(problem: AllocationProblem, count: int) -> AllocationProblem:
    """The first samples of a problem."""
    names = ("lever", "normals", "normal_min", "normal_max", "wrench", "normal_fixed")
    return replace(problem, **{name: getattr(problem, name)[:count] for name in names})


def trajectory(count: int = 6) -> AllocationProblem:
    """One grasp whose wrench swings."""
    problem = random_problem(np.random.default_rng(12), 1, 4, "tangential")
    names = ("lever", "normals", "normal_min", "normal_max", "normal_fixed", "wrench")
    many = {name: np.repeat(getattr(problem, name), count, axis=0) for name in names}
    many["wrench"][:, 1] += 0.5 * np.sin(np.linspace(0.0, np.pi, count))
    return replace(problem, **many)


def assert_proven(allocation) -> None:
    """The laws; CVXPY's answers keep its own residual, they are not polished."""
    ok, rest = allocation.feasible, 1e-8 if allocation.solver == "cvxpy" else 1e-9
    force, moment = allocation.wrench_residual()
    assert np.all(np.isnan(allocation.force[~ok]))
    assert np.all(np.isfinite(allocation.force[ok]))
    assert force[ok].max(initial=0.0) <= rest
    assert moment[ok].max(initial=0.0) <= rest
    assert allocation.cone_margin()[ok].min(initial=0.0) >= -rest
    assert allocation.bound_violation()[ok].max(initial=0.0) <= 1e-8
    assert allocation.ramp_residual()[ok].max(initial=0.0) <= rest
