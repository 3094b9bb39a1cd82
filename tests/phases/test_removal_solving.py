"""Several starts: the answer kept is the cheapest, and local optima are left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.removal import held_grasp
from pivotgait.exceptions import SolverError
from pivotgait.models import export_scene, parse_scene
from pivotgait.phases.removal import RemovalOptions, removal_problem
from pivotgait.phases.removal_nlp import solve_removal
from pivotgait.phases.removal_problem import RemovalProblem, removal_cost
from pivotgait.phases.removal_solving import best_forces, solve_with

EDITS = (
    ("along_m: 0.020", "along_m: 0.030"),
    ("along_m: 0.024", "along_m: 0.030"),
    ("middle, along_m: 0.030", "middle, along_m: 0.015"),
    ("around_deg: 79", "around_deg: 90"),
    ("around_deg: 281", "around_deg: 270"),
    ("{min: 1.0, max: 5.0}", "{min: 0.3, max: 4.0}"),
    ("{min: 0.5, max: 5.0}", "{min: 0.3, max: 4.0}"),
    ("{min: 0.1, max: 6.0}", "{min: 0.02, max: 6.0}"),
    ("friction_reserve: 0.45", "friction_reserve: 0.25"),
    ("pitch_deg: 35", "pitch_deg: 25"),
)
"""A wrench held in the middle of its bar's narrow sides, with the middle finger in front."""


@pytest.fixture(scope="module")
def slow_wrench() -> RemovalProblem:
    """Four seconds for the wrench's index finger: one start ends in a swing that costs thrice."""
    text = export_scene("wrench")
    for old, new in EDITS:
        assert old in text, f"{old!r} is not in the scene"
        text = text.replace(old, new)
    setting, grasp = held_grasp(parse_scene(text, where="edited wrench"))
    staying = [each for name, each in grasp.fingers.items() if name != "index"]
    options = RemovalOptions(4.0, 64)
    found = removal_problem(setting, grasp, staying, grasp.fingers["index"], options)
    return replace(found, force_rate_max=np.inf)


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
