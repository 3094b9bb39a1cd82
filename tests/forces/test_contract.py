"""One contract for every allocation solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.forces import OBJECTIVES, SOLVERS, AllocationProblem, LinearRows, allocate
from tests.forces.cases import assert_proven, head, problem_for, trajectory

pytestmark = pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
CONES = ("interior_point", "clarabel", "cvxpy")
SERVED = [(s, o) for s in SOLVERS for o in OBJECTIVES if (s, o) != ("proxqp", "margin")]


@pytest.mark.parametrize(("solver", "objective"), SERVED)
@pytest.mark.parametrize("contacts", [2, 3, 4, 5])
def test_forces_satisfy_every_constraint(solver, objective, contacts):
    if solver == "cvxpy" and contacts in (2, 5):
        pytest.skip("the reference is slow; it shares its rows with 3 and 4")
    allocation = allocate(problem_for(solver, objective, contacts), solver)
    assert allocation.feasible.any()
    assert_proven(allocation)


@pytest.mark.parametrize("solver", ["interior_point", "clarabel"])
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_turning_the_whole_problem_turns_the_forces(solver, objective):
    problem = problem_for(solver, objective)
    turn = Rotation.from_rotvec((0.4, -1.1, 2.0)).as_matrix()
    turned = replace(
        problem,
        lever=problem.lever @ turn.T,
        normals=problem.normals @ turn.T,
        wrench=(problem.wrench.reshape(-1, 2, 3) @ turn.T).reshape(-1, 6),
    )
    here, there = allocate(problem, solver), allocate(turned, solver)
    assert np.array_equal(here.feasible, there.feasible)
    ok = here.feasible
    same = ok & np.isclose(there.objective, here.objective, rtol=1e-6, atol=0.0)
    # Starts may fall into another local minimum of alignment, rarely; the others have but one.
    assert same.sum() >= (ok.sum() - 1 if objective == "alignment" else ok.sum())
    # Objectives are flat near their optimum: forces agree to the root of the objective.
    assert there.force[same] == pytest.approx(here.force[same] @ turn.T, abs=2e-3)


@pytest.mark.parametrize("solver", ["interior_point", "clarabel"])
@pytest.mark.parametrize(
    ("objective", "degree"), [("alignment", 0), ("tangential", 1), ("effort", 2), ("margin", 0)]
)
def test_scaling_forces_scales_the_objective(solver, objective, degree):
    problem = problem_for(solver, objective)
    factor = 7.5
    large = replace(
        problem,
        wrench=factor * problem.wrench,
        normal_min=factor * problem.normal_min,
        normal_max=factor * problem.normal_max,
    )
    small, big = allocate(problem, solver), allocate(large, solver)
    ok = small.feasible
    assert np.array_equal(ok, big.feasible)
    expected = factor**degree * small.objective
    same = np.isclose(big.objective, expected, rtol=1e-6, atol=0.0)
    assert same[ok].sum() >= (ok.sum() - 1 if objective == "alignment" else ok.sum())


@pytest.mark.parametrize("solver", SOLVERS)
def test_ramps_prescribe_normal_forces_down_to_none(solver):
    count = 5
    problem = head(random_problem(np.random.default_rng(2), 1, 4, "tangential"), 1)
    repeated = {
        name: np.repeat(getattr(problem, name), count, axis=0)
        for name in ("lever", "normals", "normal_max", "wrench", "normal_min", "normal_fixed")
    }
    repeated["normal_min"][:, 3] = 0.0
    repeated["normal_fixed"][:, 3] = np.linspace(0.8, 0.0, count)
    allocation = allocate(replace(problem, **repeated), solver).require()
    assert_proven(allocation)
    assert np.all(allocation.force[-1, 3] == 0.0)
    assert allocation.normal_force[:, 3] == pytest.approx(np.linspace(0.8, 0.0, count), abs=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
def test_rows_bind(solver):
    problem = problem_for(solver, "effort")
    free = allocate(problem, "interior_point").require()
    t, m = problem.samples, problem.contacts
    pick = np.zeros((t, 2, 3 * m))
    pick[:, 0, 3:6] = problem.normals[:, 1]
    pick[:, 1, 6:9] = problem.normals[:, 2]
    low = np.stack((free.normal_force[:, 1] + 0.2, np.full(t, -np.inf)), axis=1)
    high = np.stack((np.full(t, np.inf), free.normal_force[:, 2] + 0.5), axis=1)
    bound = allocate(replace(problem, rows=LinearRows(pick, low, high)), solver).require()
    assert_proven(bound)
    assert bound.normal_force[:, 1] == pytest.approx(low[:, 0], abs=1e-6)
    assert np.all(bound.objective > free.objective)


@pytest.mark.parametrize("solver", ["interior_point", "clarabel", "cvxpy", "proxqp"])
def test_rows_whose_limits_meet_are_equations(solver):
    problem = head(problem_for(solver, "effort"), 2)
    free = allocate(problem, "interior_point").require()
    pick = np.zeros((2, 1, 12))
    pick[:, 0, 3:6] = problem.normals[:, 1]
    value = free.normal_force[:, 1:2] + 0.1
    bound = allocate(replace(problem, rows=LinearRows(pick, value, value)), solver).require()
    assert bound.normal_force[:, 1] == pytest.approx(value[:, 0], abs=1e-9)


def test_proxqp_names_the_objectives_it_serves():
    with pytest.raises(InputError, match="alignment, tangential, effort"):
        allocate(problem_for("proxqp", "margin"), "proxqp")


def test_an_unknown_solver_is_named():
    with pytest.raises(UnknownNameError, match="interior_point"):
        allocate(trajectory(), "interior_pont")


def test_a_wrench_two_contacts_cannot_apply_is_infeasible():
    problem = problem_for("clarabel", "tangential", contacts=2)
    wrench = np.array(problem.wrench)
    between = problem.lever[:, 1] - problem.lever[:, 0]
    wrench[:, 3:] += 0.1 * between / np.linalg.norm(between, axis=1, keepdims=True)
    for solver in CONES:
        few = head(replace(problem, wrench=wrench), 2)
        assert not allocate(few, solver).feasible.any()


@pytest.mark.parametrize("solver", CONES)
@pytest.mark.parametrize("normal_max", [4.0, 40.0])
def test_alignment_squeezes_as_hard_as_it_may(solver, normal_max):
    # Two antipodal fingers and a weight: sin^2 = 1 / (1 + f_n^2) falls for ever.
    problem = AllocationProblem(
        names=("thumb", "index"),
        lever=np.array([[[0.0, 0.01, 0.0], [0.0, -0.01, 0.0]]]),
        normals=np.array([[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]]),
        friction=np.full(2, 0.8),
        normal_min=np.full((1, 2), 0.3),
        normal_max=np.full((1, 2), normal_max),
        wrench=np.array([[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]]),
    )
    allocation = allocate(problem, solver).require()
    assert allocation.normal_force == pytest.approx(np.full((1, 2), normal_max), rel=1e-5)
    assert allocation.objective == pytest.approx(2.0 / (1.0 + normal_max**2), rel=1e-5)


def test_results_are_frozen():
    allocation = allocate(trajectory())
    for array in (allocation.force, allocation.objective, allocation.problem.wrench):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_no_load_at_all_is_feasible_and_any_wrench_is_not():
    problem = trajectory(2)
    zero = np.zeros((2, 4))
    wrench = np.zeros((2, 6))
    wrench[1, 2] = 1.0
    idle = replace(problem, normal_min=zero, normal_fixed=zero, wrench=wrench)
    for solver in ("interior_point", "clarabel"):
        allocation = allocate(idle, solver)
        assert allocation.feasible.tolist() == [True, False]
        assert np.all(allocation.force[0] == 0.0)


@pytest.mark.parametrize("solver", ["interior_point", "clarabel", "proxqp"])
def test_forces_that_the_equations_decide(solver):
    # Two contacts leave one unknown, the squeeze: a ramp prescribes that as well.
    problem = replace(problem_for("proxqp", "tangential", contacts=2), normal_fixed=None)
    free = allocate(problem, solver)
    fixed = np.full((problem.samples, 2), np.nan)
    fixed[:, 1] = free.normal_force[:, 1]
    fixed[~free.feasible, 1] = 1.0
    decided = allocate(replace(problem, normal_fixed=fixed), solver)
    assert np.all(decided.feasible[free.feasible])
    assert_proven(decided)
    assert decided.force[free.feasible] == pytest.approx(free.force[free.feasible], abs=1e-6)
