"""Removals: the laws of the answer, its optimality, and what must not change it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InfeasibleError, PivotGaitError
from pivotgait.phases.removal_nlp import solve_removal
from pivotgait.phases.removal_problem import (
    RemovalProblem,
    RemovalSolution,
    RemovalWeights,
    integrate,
    removal_cost,
)
from pivotgait.phases.removal_solving import resample, solve_with
from pivotgait.phases.static_grasp import smallest_turn

Array = NDArray[np.float64]
Fixture = Callable[..., Any]
CASES = [("knife", 2), ("screwdriver", 2), ("screwdriver", 4), ("wrench", 2)]
EVERY = pytest.mark.parametrize(("name", "place"), CASES)
SAME_OPTIMUM = 1e-4
"""Relative difference in cost of two solvers, each converged to 1e-8 of a scaled cost of 1."""
RELAXED_RAD = 2e-6
"""FATROP breaks inequalities by up to 1e-8, IPOPT by up to 1e-9, whatever tolerance of optimality
they are given, and CasADi offers no option of FATROP's against it. The wrench can be held in a
strip of orientations that ends in a sharp tip: there this moves the angle by 1.03e-6 rad."""


@EVERY
def test_removal_keeps_every_law(
    moment: Fixture, planned: Fixture, assert_laws: Fixture, name: str, place: int
) -> None:
    before, (phase, after) = moment(name, place), planned(name, place)
    assert_laws(before, phase)
    assert phase.kind == "removal"
    assert phase.finger == before.finger
    assert set(phase.contacts) == {"pivot", *before.grasp.fingers}
    assert list(after.fingers) == [f for f in before.grasp.fingers if f != before.finger]
    assert before.finger not in after.forces


@EVERY
def test_normal_force_follows_the_ramp_to_nothing(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    phase, _ = planned(name, place)
    track = phase.contacts[moment(name, place).finger]
    along = np.sum(track.force * track.world_normal(phase.tool), axis=1)
    share = 1.0 - np.arange(len(along)) / (len(along) - 1)
    # the ramp is data of the program, not a row: rounding of turning it to the world and back
    np.testing.assert_allclose(along, share * along[0], atol=1e-13)
    np.testing.assert_array_equal(track.force[-1], 0.0)
    assert along[0] > 0.0


@EVERY
def test_motion_is_the_euler_integral_of_its_acceleration(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    phase, _ = planned(name, place)
    orientation, omega = integrate(moment(name, place).problem, phase.tool.angular_acceleration)
    # 64 steps, each an equality of the solver kept to about 1e-10
    turn = Rotation.from_quat(orientation).inv() * phase.tool.rotation
    assert turn.magnitude().max() < 1e-8
    np.testing.assert_allclose(omega, phase.tool.angular_velocity, atol=1e-8)


@EVERY
def test_rate_of_finger_forces_is_kept(
    moment: Fixture, solved: Fixture, name: str, place: int
) -> None:
    problem = moment(name, place).problem
    assert solved(name, place, "fatrop").largest_rate(problem) <= problem.force_rate_max


@EVERY
@pytest.mark.parametrize("solver", ["fatrop", "ipopt", "socp"])
def test_first_order_conditions_hold(solved: Fixture, name: str, place: int, solver: str) -> None:
    # costs are 1e-3 to 1e-1: a residual of 1e-6 is a part in a thousand of the smallest
    assert solved(name, place, solver).kkt_residual < 1e-6


@EVERY
def test_cost_is_that_of_the_answer(
    moment: Fixture, planned: Fixture, solved: Fixture, name: str, place: int
) -> None:
    problem, solution = moment(name, place).problem, solved(name, place, "fatrop")
    assert solution.cost == pytest.approx(cost_by_hand(problem, solution), rel=1e-9)
    args = solution.orientation, solution.angular_acceleration, solution.force
    assert solution.cost == removal_cost(problem, *args)
    assert planned(name, place)[0].record["cost"] == pytest.approx(solution.cost, rel=1e-6)


def cost_by_hand(problem: RemovalProblem, solution: RemovalSolution) -> float:
    """Section IV-A with arccos and norms, contact by contact."""
    rotation = Rotation.from_quat(solution.orientation)
    delta = (rotation[0].inv() * rotation[-1]).magnitude()
    total = problem.weights.reorientation * 4.0 * np.sin(0.5 * delta) ** 2
    for k in range(1, problem.steps + 1):
        sigma = solution.angular_acceleration[k]
        total += problem.weights.acceleration * problem.step_s * float(sigma @ sigma)
        turn = rotation[k].as_matrix()
        normals = [np.array([0.0, 0.0, 1.0]), *(turn @ frame[:, 2] for frame in problem.frames)]
        for force, normal in zip(solution.force[k], normals, strict=True):
            if np.linalg.norm(force) > 0.0:
                sine = np.linalg.norm(np.cross(normal, force)) / np.linalg.norm(force)
                total += problem.weights.alignment * problem.step_s * sine**2
    return float(total)


@EVERY
@pytest.mark.parametrize("peer", ["ipopt", "socp"])
def test_solvers_agree(solved: Fixture, name: str, place: int, peer: str) -> None:
    ours, theirs = solved(name, place, "fatrop"), solved(name, place, peer)
    assert ours.cost == pytest.approx(theirs.cost, rel=SAME_OPTIMUM)
    apart = Rotation.from_quat(ours.orientation).inv() * Rotation.from_quat(theirs.orientation)
    # the cost is quadratic about the optimum: a hundredth of its root, 1e-2 rad, at most
    assert apart.magnitude().max() < 1e-3


@EVERY
def test_doubling_reaches_the_same_optimum(solved: Fixture, name: str, place: int) -> None:
    direct, doubled = solved(name, place, "fatrop"), solved(name, place, "fatrop", True)
    assert doubled.cost == pytest.approx(direct.cost, rel=SAME_OPTIMUM)


@EVERY
def test_no_perturbed_start_leads_to_a_lower_cost(
    moment: Fixture, solved: Fixture, name: str, place: int
) -> None:
    problem, best = moment(name, place).problem, solved(name, place, "fatrop")
    # where the rate of forces binds, doing without it is cheaper from any start
    free = replace(problem, force_rate_max=np.inf)
    lowest = solve_with(free, "fatrop").cost
    assert lowest <= best.cost * (1.0 + SAME_OPTIMUM)
    rng, found = np.random.default_rng(9), []
    for size in (0.02, 0.05, 0.1, 0.1, 0.2, 0.2):
        try:
            answer = solve_removal(free, guess=perturbed(best, rng, size))
        except PivotGaitError:
            continue
        found.append(answer.cost)
    assert len(found) >= 3  # enough of them converge to mean something
    assert min(found) >= lowest * (1.0 - SAME_OPTIMUM)
    assert np.median(found) == pytest.approx(lowest, rel=SAME_OPTIMUM)


def perturbed(best: RemovalSolution, rng: np.random.Generator, size: float) -> RemovalSolution:
    """Another path of the tool with other forces, ``size`` rad and relative force away."""
    swing = np.sin(np.pi * np.linspace(0.0, 1.0, len(best.orientation)))[:, None]
    turn = Rotation.from_rotvec(size * swing * rng.normal(size=3))
    noise = 1.0 + size * rng.normal(size=best.force.shape)
    return replace(
        best,
        orientation=(turn * Rotation.from_quat(best.orientation)).as_quat(),
        angular_velocity=best.angular_velocity + size * swing * rng.normal(size=3),
        force=best.force * noise,
        multipliers=None,
    )


@EVERY
def test_reorientation_is_at_least_the_smallest_static_turn(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    phase, _ = planned(name, place)
    need = smallest_turn(moment(name, place).problem)
    assert need.feasible
    # both are kept with the same reserves
    assert np.radians(phase.reorientation_deg) >= need.angle - RELAXED_RAD
    recorded = phase.record["smallest_static_turn_deg"]
    assert recorded == pytest.approx(np.degrees(need.angle), abs=1e-5)
    assert phase.record["static_without_turning"] == (need.angle < 1e-4)


@EVERY
def test_a_heavier_weight_on_reorientation_never_turns_the_tool_more(
    moment: Fixture, name: str, place: int
) -> None:
    problem = moment(name, place).problem
    turns = []
    for weight in (0.1, 1.0, 10.0):
        weights = RemovalWeights(reorientation=weight)
        solution = solve_with(replace(problem, weights=weights), "fatrop")
        ends = Rotation.from_quat(solution.orientation[[0, -1]])
        turns.append((ends[0].inv() * ends[1]).magnitude())
    assert turns[1] <= turns[0] + RELAXED_RAD
    assert turns[2] <= turns[1] + RELAXED_RAD


@EVERY
def test_turning_the_scene_about_the_vertical_turns_the_answer(
    moment: Fixture, solved: Fixture, name: str, place: int
) -> None:
    problem, here = moment(name, place).problem, solved(name, place, "fatrop")
    about = Rotation.from_euler("z", 77.0, degrees=True)
    elsewhere = replace(
        problem,
        orientation=(about * Rotation.from_quat(problem.orientation)).as_quat(),
        start_force=problem.start_force @ about.as_matrix().T,
    )
    there = solve_with(elsewhere, "fatrop")
    assert there.cost == pytest.approx(here.cost, rel=1e-6)
    turned = about * Rotation.from_quat(here.orientation)
    apart = turned.inv() * Rotation.from_quat(there.orientation)
    # the same optimum to the solver's tolerance, see SAME_OPTIMUM
    assert apart.magnitude().max() < 1e-3


@EVERY
def test_the_sign_of_the_starting_quaternion_does_not_matter(
    moment: Fixture, solved: Fixture, name: str, place: int
) -> None:
    problem = moment(name, place).problem
    other = solve_with(replace(problem, orientation=-problem.orientation), "fatrop")
    assert other.cost == pytest.approx(solved(name, place, "fatrop").cost, rel=1e-6)


@pytest.mark.parametrize(("name", "place", "pitch"), [("knife", 2, 10), ("wrench", 2, 10)])
def test_a_low_tool_keeps_its_clearance_over_the_table(
    moment: Fixture, planned: Fixture, assert_laws: Fixture, name: str, place: int, pitch: int
) -> None:
    # lifted this little, the tool would come nearer than its clearance were it not forbidden
    low = (f"pitch_deg: {35 if name == 'wrench' else 25}", f"pitch_deg: {pitch}")
    before, (phase, _) = moment(name, place, low), planned(name, place, low)
    assert_laws(before, phase)
    scene = before.setting.scene
    height = scene.height(phase.tool.rotation)
    assert height.min() >= scene.clearance
    # it binds: the reserve is a micrometre
    assert height.min() <= scene.clearance + 2e-6
    problem = before.problem
    free = solve_with(replace(problem, clear_rise=np.full(len(problem.clear_rise), -1.0)), "fatrop")
    assert scene.height(Rotation.from_quat(free.orientation)).min() < scene.clearance
    # what is forbidden less can only be cheaper
    assert free.cost <= phase.record["cost"] * (1.0 + SAME_OPTIMUM)


def test_removal_that_no_orientation_can_end_names_the_contacts(moment: Fixture) -> None:
    before = moment("wrench", 2)
    slippery = {each: replace(c, friction=0.15) for each, c in before.grasp.fingers.items()}
    grasp = replace(before.grasp, fingers=slippery)
    with pytest.raises(InfeasibleError) as caught:
        replace(before, grasp=grasp).plan()
    for contact in ("index", "pivot", "thumb", "middle"):
        assert contact in str(caught.value)
    assert "friction" in caught.value.mend
    assert caught.value.where == "phase"


@pytest.mark.parametrize("steps", [24, 48, 100])
def test_more_steps_tend_to_the_same_motion(moment: Fixture, solved: Fixture, steps: int) -> None:
    # cost and reorientation converge at first order with the step
    problem, best = moment("screwdriver", 2).problem, solved("screwdriver", 2, "fatrop")
    other = replace(problem, steps=steps, step_s=problem.step_s * problem.steps / steps)
    assert solve_with(other, "fatrop").cost == pytest.approx(best.cost, rel=2.0 / steps)


def test_resampling_to_the_same_samples_changes_nothing(moment: Fixture, solved: Fixture) -> None:
    problem, best = moment("knife", 2).problem, solved("knife", 2, "fatrop")
    again = resample(best, problem)
    apart = Rotation.from_quat(again.orientation).inv() * Rotation.from_quat(best.orientation)
    assert apart.magnitude().max() < 1e-12
    np.testing.assert_allclose(again.force, best.force, atol=1e-13)
    np.testing.assert_allclose(again.angular_velocity, best.angular_velocity, atol=1e-13)
    half = resample(best, replace(problem, steps=32, step_s=2 * problem.step_s))
    np.testing.assert_allclose(half.force, best.force[::2], atol=1e-13)


def test_integration_of_a_constant_axis_is_the_sum_of_its_angles(moment: Fixture) -> None:
    problem = moment("knife", 2).problem
    axis = np.array([0.6, 0.0, 0.8])
    sigma = np.sin(np.arange(problem.steps + 1))[:, None] * axis
    orientation, omega = integrate(problem, sigma)
    h = problem.step_s
    speed = h * np.concatenate(([0.0], np.cumsum(np.sin(np.arange(problem.steps)))))
    np.testing.assert_allclose(omega, speed[:, None] * axis, atol=1e-14)
    angle = h * speed[:-1].sum()
    wanted = Rotation.from_rotvec(angle * axis) * Rotation.from_quat(problem.orientation)
    assert (wanted.inv() * Rotation.from_quat(orientation[-1])).magnitude() < 1e-13
