"""Problems whose samples are coupled by force rates and prescribed ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.forces import OBJECTIVES, allocate
from tests.forces.cases import trajectory

pytestmark = pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
COUPLING = ("clarabel", "cvxpy")


@pytest.mark.parametrize("solver", COUPLING)
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_coupled_rows_hold(solver, objective):
    problem = replace(trajectory(), objective=objective)
    loose = allocate(replace(problem, objective="tangential"), "interior_point").require()
    effort = allocate(replace(problem, objective="effort"), "interior_point").require()
    start = effort.force[0]
    jump = np.linalg.norm(loose.force[-1] - start, axis=-1).max()
    limited = replace(problem, start=start, force_rate_max=0.5 * jump / 0.01, step_s=0.01)
    allocation = allocate(limited, solver).require()
    # The reference's programs end "inaccurate" on the thin sets that rates leave.
    rest = 1e-6 if solver == "cvxpy" else 1e-8
    assert np.all(allocation.cone_margin() >= -rest)
    assert max(part.max() for part in allocation.wrench_residual()) <= rest
    assert allocation.force[0] == pytest.approx(start, abs=rest)
    assert allocation.rate_violation() <= rest
    assert allocate(limited).solver == "clarabel"
    ended = allocate(replace(limited, end=loose.force[-1]), solver).require()
    assert ended.force[-1] == pytest.approx(loose.force[-1], abs=rest)


def test_coupled_solvers_agree_and_pay_for_the_coupling():
    problem = trajectory()
    free = allocate(problem, "interior_point")
    limited = replace(problem, force_rate_max=25.0, step_s=0.01)
    ours, reference = allocate(limited, "clarabel"), allocate(limited, "cvxpy")
    assert free.objective.sum() < ours.objective.sum() * (1 - 1e-6)
    assert ours.objective.sum() == pytest.approx(reference.objective.sum(), rel=1e-6)


def test_a_rate_too_slow_for_its_ends_is_infeasible():
    problem = trajectory()
    first = allocate(replace(problem, objective="effort")).force[0]
    last = allocate(problem).force[-1]
    slow = replace(problem, start=first, end=last, force_rate_max=1.0, step_s=0.01)
    for solver in COUPLING:
        assert not allocate(slow, solver).feasible.any()
    with pytest.raises(InfeasibleError, match="rate"):
        allocate(slow).require()


def test_a_start_outside_its_cone_is_infeasible():
    problem = trajectory()
    start = np.array(allocate(problem).force[0])
    start[1] += 5.0
    for solver in COUPLING:
        assert not allocate(replace(problem, start=start), solver).feasible.any()


@pytest.mark.parametrize("solver", ["interior_point", "proxqp"])
def test_uncoupled_solvers_refuse_coupled_problems(solver):
    with pytest.raises(InputError, match="clarabel"):
        allocate(replace(trajectory(), force_rate_max=1.0, step_s=0.1), solver)


def test_an_alignment_that_stalls_says_so():
    problem = random_problem(np.random.default_rng(5), 60, 5, "alignment", spread=2)
    tame = allocate(problem.sample(0), "clarabel")
    assert tame.converged
    # Free to vanish, forces of contacts that are given up do, and curvature grows without bound.
    free = replace(problem, normal_min=np.zeros(problem.normal_min.shape))
    stalled = allocate(free, "clarabel")
    assert not stalled.converged
    assert stalled.cone_margin()[stalled.feasible].min() >= -1e-9
