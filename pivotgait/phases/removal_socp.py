"""Finger removal by successive second-order cone programs (Clarabel): the second opinion.

A trust-region method: each round solves the cone program of the problem linearised about the
last trajectory, with an exact penalty on the residuals of moment and table force so that it
has a solution far from balance too, and keeps the step if cost plus penalty fall. Where they
fall short of what the program promised, the curvature of the dynamics is to blame and a
second-order correction is tried, so that steps stay long when the tool has to turn far.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import SolverError
from pivotgait.phases.removal_linearised import (
    Dynamics,
    Trajectory,
    dynamics,
)
from pivotgait.phases.removal_nlp import balance
from pivotgait.phases.removal_problem import RemovalProblem, RemovalSolution, removal_cost
from pivotgait.phases.removal_round import COST_SCALE, FORCE, PENALTY, Round, Step

Array = NDArray[np.float64]

MAX_ROUNDS = 80
STEP_TOLERANCE = 1e-7
"""Change of orientation [rad] and relative change of cost below which a round is the last."""
GOOD = 0.7
"""Share of the promised gain from which a step needs no correction and the next may be longer."""
MERIT_NOISE = 5e-8
"""Change of the merit that says nothing: twice what the penalty makes of Clarabel's residuals."""


def solve_removal_by_socps(
    problem: RemovalProblem, guess: RemovalSolution | None = None
) -> RemovalSolution:
    """Solve the removal problem of Section IV-A on exact cones.

    Args:
        problem: the numbers.
        guess: a solution of a like problem with the same number of steps.

    Raises:
        SolverError: no convergence, or a moment remains that no forces balance.
    """
    trajectory = _start(problem, guess)
    here, radius = _merit(problem, trajectory), 0.2
    optimality, rounds = np.inf, 0
    while rounds < MAX_ROUNDS:
        rounds += 1
        step, there, predicted = _propose(problem, trajectory, here, radius)
        gained, noise = here - there, MERIT_NOISE * max(1.0, here)
        optimality = step.optimality
        if gained > 0.1 * predicted or abs(gained) <= noise:
            trajectory, here = step.trajectory, there
            radius = min(2.0 * radius, 0.5) if gained > GOOD * predicted else radius
        else:
            radius *= 0.3
        if step.turn < STEP_TOLERANCE and abs(predicted) <= max(STEP_TOLERANCE * here, noise):
            break
        if radius < 1e-9:
            break
    state = dynamics(problem, trajectory)
    miss = float(np.abs(state.moment).max())
    if miss > 1e-7:
        raise SolverError(
            f"successive cone programs left a moment of {miss:.1e} N m after {rounds} rounds",
            where="removal",
            mend="give more time or steps, more friction, or a smaller starting force",
        )
    if optimality > 1e-5:
        raise SolverError(
            f"successive cone programs came no nearer to an optimum than {optimality:.1e}",
            where="removal",
            mend="try the solver ipopt",
        )
    return _solution(problem, trajectory, state, rounds, max(optimality, miss))


def _propose(
    problem: RemovalProblem, trajectory: Trajectory, here: float, radius: float
) -> tuple[Step, float, float]:
    """A step from a trajectory of merit ``here``, the merit there, and the gain promised."""
    model = Round(problem, trajectory, radius)
    plain = model.solve()
    merit, predicted = _merit(problem, plain.trajectory), here - plain.model
    if here - merit >= GOOD * predicted:
        return plain, merit, predicted
    corrected = model.solve(plain.bend)
    other = _merit(problem, corrected.trajectory)
    return (corrected, other, predicted) if other < merit else (plain, merit, predicted)


def _start(problem: RemovalProblem, guess: RemovalSolution | None) -> Trajectory:
    steps, ramp = problem.steps, problem.ramp
    if guess is not None:
        turn = Rotation.from_quat(guess.orientation[1:]).as_matrix()
        frames = np.einsum("kij,mjl->kmil", turn, problem.frames)
        local = np.einsum("kmil,kmi->kml", frames, guess.force[1:, 1:])
        return Trajectory.of(problem, guess.angular_acceleration[1:], local)
    held = problem.start_local
    local = np.tile(held, (steps, 1, 1))
    local[:, -1] *= (ramp[1:] / ramp[0])[:, None]
    return Trajectory.of(problem, np.zeros((steps, 3)), local)


def _violation(problem: RemovalProblem, trajectory: Trajectory, state: Dynamics) -> float:
    """Sum of what no linearised round guarantees: moment, table cone and bounds, clearance."""
    table, mu = state.table, problem.friction[0]
    over = [
        np.abs(state.moment).ravel(),
        FORCE * (np.linalg.norm(table[:, :2], axis=1) - mu * table[:, 2]).clip(0.0),
        FORCE * (problem.normal_min[0] - table[:, 2]).clip(0.0),
        FORCE * (table[:, 2] - problem.normal_max[0]).clip(0.0),
        (problem.clear_rise - trajectory.rotation[:, 2, :] @ problem.clear_lever.T)
        .clip(0.0)
        .ravel(),
    ]
    return float(sum(part.sum() for part in over))


def _forces(problem: RemovalProblem, trajectory: Trajectory, state: Dynamics) -> Array:
    frames = np.einsum("kij,mjl->kmil", trajectory.rotation, problem.frames)
    force = np.empty((problem.steps + 1, problem.staying + 2, 3))
    force[0], force[1:, 0] = problem.start_force, state.table
    force[1:, 1:] = np.einsum("kmil,kml->kmi", frames, trajectory.local)
    return force


def _orientations(problem: RemovalProblem, trajectory: Trajectory) -> Array:
    turns = Rotation.from_matrix(trajectory.rotation).as_quat()
    signs = np.where(turns @ problem.orientation < 0.0, -1.0, 1.0)
    return np.vstack((problem.orientation, signs[:, None] * turns))


def _merit(problem: RemovalProblem, trajectory: Trajectory) -> float:
    state = dynamics(problem, trajectory)
    cost = removal_cost(
        problem,
        _orientations(problem, trajectory),
        np.vstack((np.zeros(3), trajectory.sigma)),
        _forces(problem, trajectory, state),
    )
    violation = _violation(problem, trajectory, state)
    return COST_SCALE * cost + PENALTY * violation


def _solution(
    problem: RemovalProblem, trajectory: Trajectory, state: Dynamics, rounds: int, kkt: float
) -> RemovalSolution:
    orientation = _orientations(problem, trajectory)
    omega = np.vstack((np.zeros(3), trajectory.omega))
    omega[-1] = 0.0
    sigma = np.vstack((np.zeros(3), trajectory.sigma))
    force = _forces(problem, trajectory, state)
    force[-1, -1] = 0.0
    balance(problem, orientation, omega, sigma, force)
    cost = removal_cost(problem, orientation, sigma, force)
    return RemovalSolution(orientation, omega, sigma, force, cost, "socp", rounds, kkt)
