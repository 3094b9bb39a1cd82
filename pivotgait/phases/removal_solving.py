"""The solvers of a removal under one name, from several starts, directly or by doubling K."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.dynamics import required_wrench
from pivotgait.exceptions import SolverError
from pivotgait.forces import AllocationProblem, allocate
from pivotgait.phases.removal_nlp import solve_removal
from pivotgait.phases.removal_problem import RemovalProblem, RemovalSolution
from pivotgait.phases.removal_socp import solve_removal_by_socps
from pivotgait.phases.timing import quintic

Array = NDArray[np.float64]
RemovalSolver = Literal["fatrop", "ipopt", "socp"]

LARGEST_STEP_RAD = 0.4
"""Rotation within one step for which the program's series of the exponential is exact."""
SAME_COST = 1e-2
"""Relative difference of cost above which two starts ended in different local optima."""


def solve_with(
    problem: RemovalProblem,
    solver: RemovalSolver,
    *,
    doubling: bool = False,
    toward: Array | None = None,
) -> RemovalSolution:
    """Solve a removal problem with a named solver, directly or by doubling K.

    Args:
        problem: the numbers.
        solver: ``fatrop`` tries several starts; the others take one.
        doubling: scale K up as the paper does.
        toward: (4,) an orientation in which the staying fingers hold the tool at rest, xyzw: a
            start for a removal that has to turn far.

    Raises:
        SolverError: not converged, or steps too coarse for the integration.
    """
    guess: RemovalSolution | None = None
    for steps in _rounds(problem.steps) if doubling else ():
        coarse = replace(problem, steps=steps, step_s=problem.step_s * problem.steps / steps)
        try:
            guess = _solve(
                coarse, solver, None if guess is None else resample(guess, coarse), toward
            )
        except SolverError:  # a coarse grid may be infeasible where the fine one is not
            guess = None
    solution = _solve(problem, solver, None if guess is None else resample(guess, problem), toward)
    turn = float(np.linalg.norm(solution.angular_velocity, axis=1).max() * problem.step_s)
    if turn > LARGEST_STEP_RAD:
        raise SolverError(
            f"the tool turns {np.degrees(turn):.0f} deg within one step",
            where="removal.steps",
            mend="take more steps",
        )
    return solution


def best_forces(problem: RemovalProblem, solution: RemovalSolution) -> Array:
    """(K + 1, n + 2, 3) forces that align best (eq. 4) sample by sample along a solution's motion.

    Samples for which allocation finds none, the solution being on the edge of its constraints,
    keep theirs; so does k = 0, which is given.
    """
    motion = solution.motion(problem.body)
    turn = motion.rotation.as_matrix()[1:]
    levers = np.vstack((problem.body.pivot_in_tool, problem.points))
    normals = np.einsum("kij,mj->kmi", turn, np.vstack((np.zeros(3), problem.frames[:, :, 2])))
    normals[:, 0] = (0.0, 0.0, 1.0)
    fixed = np.full((problem.steps, problem.staying + 2), np.nan)
    fixed[:, -1] = problem.ramp[1:]
    answer = allocate(
        AllocationProblem(
            names=tuple(f"contact {i}" for i in range(problem.staying + 2)),
            lever=np.einsum("kij,mj->kmi", turn, levers),
            normals=normals,
            friction=problem.friction,
            normal_min=np.tile(problem.normal_min, (problem.steps, 1)),
            normal_max=np.tile(problem.normal_max, (problem.steps, 1)),
            wrench=required_wrench(problem.body, motion)[1:],
            normal_fixed=fixed,
            objective="alignment",
        )
    )
    force = solution.force.copy()
    force[1:][answer.feasible] = answer.force[answer.feasible]
    return force


def _solve(
    problem: RemovalProblem,
    solver: RemovalSolver,
    guess: RemovalSolution | None,
    toward: Array | None,
) -> RemovalSolution:
    if solver == "socp":
        return solve_removal_by_socps(problem, guess)
    if solver == "ipopt":
        return solve_removal(problem, solver=solver, guess=guess)
    if not problem.rated:
        return _best_of_starts(problem, guess, toward)
    # FATROP has no rows between stages: it solves without the rate, and if the answer keeps the
    # rate it is the optimum with it too, having had fewer constraints
    free = _best_of_starts(replace(problem, force_rate_max=np.inf), guess, toward)
    if free.largest_rate(problem) <= problem.force_rate_max:
        return free
    return solve_removal(problem, solver="ipopt", guess=replace(free, multipliers=None))


def _best_of_starts(
    problem: RemovalProblem, guess: RemovalSolution | None, toward: Array | None
) -> RemovalSolution:
    """The cheapest answer of several starts, for the problem has local optima.

    Starts: the forces of now, and those that align best along a smooth turn to ``toward`` (with
    the tool held still, without it). Where the two answers cost alike, that is it; else
    successive cone programs are asked too.
    """
    if guess is not None:
        return _fatrop_or_ipopt(problem, guess)
    found: list[RemovalSolution] = []
    missed: list[SolverError] = []
    turning = _turning(problem, problem.orientation if toward is None else toward)
    for start in (None, replace(turning, force=best_forces(problem, turning))):
        try:
            found.append(_fatrop_or_ipopt(problem, start))
        except SolverError as error:
            missed.append(error)
    costs = [each.cost for each in found]
    if len(found) < 2 or max(costs) > (1.0 + SAME_COST) * min(costs):
        try:
            found.append(solve_removal_by_socps(problem))
        except SolverError as error:
            missed.append(error)
    if not found:
        raise missed[0]
    return min(found, key=lambda each: each.cost)


def _turning(problem: RemovalProblem, toward: Array) -> RemovalSolution:
    """A smooth turn, the forces of the others as they are: a start, not a solution."""
    samples, duration = problem.steps + 1, problem.steps * problem.step_s
    fraction, rate, acceleration = quintic(np.linspace(0.0, duration, samples), duration)
    start = Rotation.from_quat(problem.orientation)
    turn = (Rotation.from_quat(toward) * start.inv()).as_rotvec()
    force = np.tile(problem.start_force, (samples, 1, 1))
    force[:, -1] *= np.linspace(1.0, 0.0, samples)[:, None]
    orientation = (Rotation.from_rotvec(fraction[:, None] * turn) * start).as_quat()
    omega, sigma = rate[:, None] * turn, acceleration[:, None] * turn
    return RemovalSolution(orientation, omega, sigma, force, np.inf, "", 0, np.inf)


def _fatrop_or_ipopt(problem: RemovalProblem, guess: RemovalSolution | None) -> RemovalSolution:
    """FATROP, and where it stalls (very low friction) the slower IPOPT."""
    try:
        return solve_removal(problem, guess=guess)
    except SolverError:
        return solve_removal(problem, solver="ipopt", guess=guess)


def _rounds(steps: int, least: int = 8) -> list[int]:
    """K/2, K/4, ... down to about ``least``, ascending."""
    rounds = []
    while steps % 2 == 0 and steps // 2 >= least:
        steps //= 2
        rounds.append(steps)
    return rounds[::-1]


def resample(solution: RemovalSolution, problem: RemovalProblem) -> RemovalSolution:
    """Interpolate a solution to the samples of another problem of the same duration."""
    old = np.linspace(0.0, 1.0, len(solution.orientation))
    new = np.linspace(0.0, 1.0, problem.steps + 1)

    def linear(values: Array) -> Array:
        flat = values.reshape(len(values), -1)
        columns = [np.interp(new, old, column) for column in flat.T]
        return np.stack(columns, axis=1).reshape(len(new), *values.shape[1:])

    slerp = Slerp(old, Rotation.from_quat(solution.orientation))
    return replace(
        solution,
        orientation=slerp(new).as_quat(),
        angular_velocity=linear(solution.angular_velocity),
        angular_acceleration=linear(solution.angular_acceleration),
        force=linear(solution.force),
        multipliers=None,
    )
