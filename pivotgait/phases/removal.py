"""Removal: unload one finger while the tool pivots to keep the others' contacts (Section IV-A)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.contacts import contact_frame
from pivotgait.exceptions import InfeasibleError, SolverError
from pivotgait.models import HandleContact
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.phases.removal_problem import RemovalProblem, RemovalSolution, RemovalWeights
from pivotgait.phases.removal_solving import RemovalSolver, solve_with
from pivotgait.phases.static_grasp import smallest_turn
from pivotgait.plans import PIVOT, Phase

Array = NDArray[np.float64]

CLEAR_POINTS = 4
"""Points kept over the table at once; the compiled program has room for this many."""


@dataclass(frozen=True)
class RemovalOptions:
    """How to remove a finger.

    Attributes:
        duration_s: [s].
        steps: number of intervals K.
        weights: of the cost.
        solver: ``fatrop`` (the fastest measured), ``ipopt``, or ``socp`` (successive
            second-order cone programs, independent of CasADi).
        doubling: scale up as the paper does: solve a coarse problem, double K, start from the
            interpolated result. On our scenes it reaches the same optimum and costs more than
            the direct solve, whose program is benign (see the closing table of ``bench``).
    """

    duration_s: float
    steps: int
    weights: RemovalWeights = field(default_factory=RemovalWeights)
    solver: RemovalSolver = "fatrop"
    doubling: bool = False


def plan_removal(
    setting: Setting, grasp: Grasp, finger: str, options: RemovalOptions, *, name: str
) -> tuple[Phase, Grasp]:
    """Plan the removal of a finger.

    Args:
        setting: tool and table.
        grasp: the tool at rest, held with known forces by this finger and others.
        finger: the one that leaves.
        options: timing, weights, solver.
        name: of the phase.

    Returns:
        The phase and the grasp it ends in.

    Raises:
        InfeasibleError: the others cannot hold the tool in any orientation nearby.
        SolverError: they can, but no trajectory was found.
    """
    staying = [contact for each, contact in grasp.fingers.items() if each != finger]
    leaving = grasp.fingers[finger]
    problem = removal_problem(setting, grasp, staying, leaving, options)
    need = smallest_turn(problem)
    if not need.feasible:
        others = ", ".join(contact.finger for contact in staying)
        raise InfeasibleError(
            f"without {finger} the contacts pivot, {others} cannot hold the tool at rest in any "
            f"orientation found ({need.reason})",
            where=name,
            mend="more friction or finger force, or other contact places",
        )
    try:
        solution = _clear_of_table(setting, problem, options, need.orientation)
    except SolverError as error:
        raise SolverError(
            f"{error.what}; at rest the others need a turn of {np.degrees(need.angle):.1f} deg",
            where=name,
            mend=error.mend,
        ) from error
    motion = solution.motion(setting.body)
    contacts = {PIVOT: setting.pivot_track(solution.force[:, 0])}
    for place, contact in enumerate([*staying, leaving], start=1):
        track = finger_track(contact, solution.force[:, place], changing=contact is leaving)
        contacts[contact.finger] = track
    record: Mapping[str, Any] = {
        "solver": solution.solver,
        "iterations": solution.iterations,
        "cost": solution.cost,
        "kkt_residual": solution.kkt_residual,
        "smallest_static_turn_deg": float(np.degrees(need.angle)),
        "static_without_turning": need.angle < 1e-4,
    }
    time = np.linspace(0.0, options.duration_s, options.steps + 1)
    phase = Phase(name, "removal", finger, time, motion, contacts, record=record)
    fingers = {contact.finger: contact for contact in staying}
    return phase, Grasp.after(motion, fingers, contacts)


def removal_problem(
    setting: Setting,
    grasp: Grasp,
    staying: list[HandleContact],
    leaving: HandleContact,
    options: RemovalOptions,
) -> RemovalProblem:
    """The numbers of a removal, with the lowest points of the tool to keep over the table."""
    scene, fingers = setting.scene, [*staying, leaving]
    problem = RemovalProblem(
        steps=options.steps,
        step_s=options.duration_s / options.steps,
        body=setting.body,
        orientation=grasp.rotation.as_quat(),
        points=np.stack([contact.point for contact in fingers]),
        frames=contact_frame(np.stack([contact.normal for contact in fingers])),
        friction=setting.usable_friction(fingers),
        normal_min=np.array([scene.table.normal_min, *(c.normal_min for c in staying), 0.0]),
        normal_max=np.array([scene.table.normal_max, *(c.normal_max for c in fingers)]),
        start_force=np.stack(
            [grasp.forces[each] for each in (PIVOT, *(c.finger for c in fingers))]
        ),
        clear_lever=np.zeros((CLEAR_POINTS, 3)),
        clear_rise=np.full(CLEAR_POINTS, -1.0),
        force_rate_max=scene.allocation.force_rate_max_N_s,
        weights=options.weights,
    )
    lever, floor = _covering(setting)
    reserve = lever @ grasp.rotation.as_matrix()[2] - floor
    return _keep_clear(problem, lever, floor, reserve)


def _covering(setting: Setting) -> tuple[Array, Array]:
    """Centres (P, 3) of the tool's covering balls relative to the pivot, tool frame, and their
    least heights (P,) over the pivot [m]."""
    tool = setting.scene.tool
    points, radii = tool.support_points()
    return points - tool.pivot_in_tool, radii + setting.scene.clearance - tool.tip_radius


def _keep_clear(
    problem: RemovalProblem, lever: Array, floor: Array, reserve: Array
) -> RemovalProblem:
    """The problem with the balls of least ``reserve`` (P,) kept over their least heights."""
    chosen = np.argsort(reserve)[:CLEAR_POINTS]
    kept, rise = np.zeros((CLEAR_POINTS, 3)), np.full(CLEAR_POINTS, -1.0)
    kept[: len(chosen)] = lever[chosen]
    # a micrometre of reserve, so that the solver's tolerance does not eat the clearance
    rise[: len(chosen)] = floor[chosen] + 1e-6
    return replace(problem, clear_lever=kept, clear_rise=rise)


def _clear_of_table(
    setting: Setting, problem: RemovalProblem, options: RemovalOptions, toward: Array
) -> RemovalSolution:
    """Solve, and solve again with the points that came too low, until none does."""
    lever, floor = _covering(setting)
    for _ in range(4):
        solution = solve_with(problem, options.solver, doubling=options.doubling, toward=toward)
        turn = Rotation.from_quat(solution.orientation).as_matrix()
        reserve = (turn[:, 2] @ lever.T - floor).min(axis=0)
        if reserve.min(initial=np.inf) >= 0.0:
            return solution
        problem = _keep_clear(problem, lever, floor, reserve)
    raise SolverError(
        "the tool's lowest points change from round to round, and one stays too near the table",
        where="removal",
        mend="lift the tool higher before the removal",
    )
