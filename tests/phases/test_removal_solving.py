"""Several starts: the answer kept is the cheapest, and local optima are left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.removal import removal_instances
from pivotgait.exceptions import SolverError
from pivotgait.phases.removal_nlp import solve_removal
from pivotgait.phases.removal_problem import RemovalProblem, removal_cost
from pivotgait.phases.removal_solving import best_forces, solve_with


@pytest.fixture(scope="module")
def slow_wrench() -> RemovalProblem:
    """Four seconds for the wrench's index finger: one start ends in a swing that costs thrice."""
    found = removal_instances()["wrench, index leaves, friction x 1.0"]
    return replace(found, step_s=4.0 / found.steps)


def test_a_second_start_leaves_a_local_optimum(slow_wrench: RemovalProblem) -> None:
    one, best = solve_removal(slow_wrench), solve_with(slow_wrench, "fatrop")
    assert best.cost < 0.5 * one.cost


def test_best_forces_never_cost_more_than_the_solutions_own(slow_wrench: RemovalProblem) -> None:
    solution = solve_with(slow_wrench, "fatrop")
    force = best_forces(slow_wrench, solution)
    np.testing.assert_array_equal(force[0], slow_wrench.start_force)
    cost = removal_cost(slow_wrench, solution.orientation, solution.angular_acceleration, force)
    # allocation has the whole friction, the solution a reserve of 1e-6 of it
    assert cost <= solution.cost * (1.0 + 1e-9)


def test_fatrop_refuses_a_bound_of_the_rate_by_itself(slow_wrench: RemovalProblem) -> None:
    with pytest.raises(SolverError, match="rate of forces"):
        solve_removal(replace(slow_wrench, force_rate_max=20.0))
