"""Solvers agree on the optimum and on feasibility, as far as each may."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.forces import OBJECTIVES, allocate
from tests.forces.cases import assert_proven, head, problem_for

pytestmark = pytest.mark.filterwarnings("ignore:Solution may be inaccurate")


@pytest.mark.parametrize("solver", ["clarabel", "cvxpy"])
@pytest.mark.parametrize("objective", ["tangential", "effort", "margin"])
def test_convex_objectives_agree(solver, objective):
    problem = problem_for(solver, objective)
    ours, theirs = allocate(problem, "interior_point"), allocate(problem, solver)
    assert np.array_equal(ours.feasible, theirs.feasible)
    ok = ours.feasible
    assert ours.objective[ok] == pytest.approx(theirs.objective[ok], rel=1e-6)


def test_alignment_is_no_worse_than_successive_programs():
    problem = random_problem(np.random.default_rng(8), 30, 5, "alignment")
    ours, theirs = allocate(problem, "interior_point"), allocate(problem, "clarabel")
    assert np.all(ours.objective <= theirs.objective * (1 + 1e-6))
    assert np.mean(np.isclose(ours.objective, theirs.objective, rtol=1e-6, atol=0.0)) > 0.8


@pytest.mark.parametrize("objective", ["tangential", "effort", "alignment"])
def test_inner_pyramid_costs_little_and_never_gains(objective):
    problem = problem_for("proxqp", objective)
    exact, pyramid = allocate(problem, "interior_point"), allocate(problem, "proxqp")
    both = exact.feasible & pyramid.feasible
    assert both.any()
    assert not np.any(pyramid.feasible & ~exact.feasible)
    assert np.all(pyramid.objective[both] >= exact.objective[both] * (1 - 1e-7))
    assert np.all(pyramid.objective[both] <= exact.objective[both] * 1.15)


def test_the_pyramid_is_exact_where_friction_does_not_bind():
    problem = problem_for("proxqp", "tangential", contacts=2)
    exact, pyramid = allocate(problem, "interior_point"), allocate(problem, "proxqp")
    free = exact.feasible & (np.nan_to_num(exact.friction_margin()).min(axis=1) > 0.1)
    assert free.any()
    assert pyramid.objective[free] == pytest.approx(exact.objective[free], rel=1e-6)


@pytest.mark.parametrize("contacts", [2, 3, 4])
def test_solvers_agree_on_feasibility(contacts):
    problem = random_problem(np.random.default_rng(contacts), 60, contacts, "tangential", spread=3)
    ours = allocate(problem, "interior_point")
    assert 0 < ours.feasible.sum() < problem.samples
    assert np.array_equal(ours.feasible, allocate(problem, "clarabel").feasible)
    few = head(problem, 12)
    assert np.array_equal(ours.feasible[:12], allocate(few, "cvxpy").feasible)
    inner = allocate(few, "proxqp").feasible
    assert not np.any(inner & ~ours.feasible[:12])
    assert_proven(ours)


def test_margin_maximises_the_smallest_margin():
    problem = problem_for("interior_point", "margin")
    best = allocate(problem, "interior_point")
    for objective in ("alignment", "tangential", "effort"):
        other = allocate(replace(problem, objective=objective), "interior_point")
        smallest = np.min(other.friction_margin(), axis=1)
        assert np.all(best.objective >= smallest - 2e-5)


def test_one_answer_whatever_the_batch_around_it():
    problem = random_problem(np.random.default_rng(6), 30, 4, "tangential", spread=2)
    together = allocate(problem, "interior_point")
    for k in (0, 11, 29):
        alone = allocate(problem.sample(k), "interior_point")
        assert alone.feasible[0] == together.feasible[k]
        assert alone.force[0] == pytest.approx(together.force[k], abs=1e-7, nan_ok=True)


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("contacts", [4, 5])
def test_samples_of_many_patterns_in_one_batch(objective, contacts):
    problem = random_problem(np.random.default_rng(77), 200, contacts, objective, spread=2)
    high, low = np.array(problem.normal_max), np.array(problem.normal_min)
    fixed = np.full(low.shape, np.nan)
    high[::3, 0] = np.inf
    low[::4] = 0.0
    low[::5, -1], fixed[::5, -1] = 0.0, 0.7
    fixed[::10, -1] = 0.0
    mixed = replace(problem, normal_max=high, normal_min=low, normal_fixed=fixed)
    allocation = allocate(mixed, "interior_point")
    assert allocation.feasible.mean() > 0.5
    assert_proven(allocation)
    some = head(mixed, 12)
    theirs = allocate(some, "clarabel")
    ok = theirs.feasible
    assert np.array_equal(allocation.feasible[:12], ok)
    # Either may find the better minimum of alignment, ours does more often.
    worse = allocation.objective[:12] > theirs.objective * (1 + 1e-6)
    if objective == "margin":
        worse = allocation.objective[:12] < theirs.objective * (1 - 1e-6)
    assert not worse[ok].any()


def test_a_margin_that_stalls_says_so():
    problem = random_problem(np.random.default_rng(45), 80, 5, "margin")
    ours, theirs = allocate(problem, "interior_point"), allocate(problem, "clarabel")
    short = ours.objective < theirs.objective - 1e-6
    assert ours.converged == (not short.any())
    assert np.mean(short) < 0.05
    tame = random_problem(np.random.default_rng(43), 40, 3, "margin")
    assert allocate(tame, "interior_point").converged
