"""Finger removal against its peers, on the built-in scenes' grasps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np

from pivotgait.exceptions import PivotGaitError
from pivotgait.models import AdditionPhase, LiftPhase, RelocationPhase, Scene, load_scene
from pivotgait.phases.addition import AdditionOptions, plan_addition
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.lift import LiftOptions, plan_lift
from pivotgait.phases.removal import RemovalOptions, removal_problem
from pivotgait.phases.removal_model import removal_program
from pivotgait.phases.removal_nlp import SCALE_PER_STEP, NlpSolver, removal_nlp, solve_removal
from pivotgait.phases.removal_packing import pack
from pivotgait.phases.removal_problem import RemovalProblem
from pivotgait.phases.removal_solving import solve_with
from pivotgait.phases.static_grasp import smallest_turn

SCENES = ("knife", "screwdriver", "wrench")
FINGERS = ("index", "thumb", "middle")
FRICTION_SCALES = (1.0, 0.85)


def held_grasp(scene: Scene) -> tuple[Setting, Grasp]:
    """A scene's tool after its lift and first addition, held by three fingers."""
    setting = Setting.of(scene)
    configs = next(iter(scene.gaits.values()))
    lift, addition, *_ = (each for each in configs if not isinstance(each, RelocationPhase))
    assert isinstance(lift, LiftPhase)
    assert isinstance(addition, AdditionPhase)
    touching = {scene.contacts[name].finger: scene.contacts[name] for name in lift.contacts}
    grasp = Grasp(scene.rest_rotation, MappingProxyType(touching))
    options = LiftOptions(lift.duration_s, lift.steps)
    _, grasp = plan_lift(setting, grasp, scene.lift_rotation(lift.to), options, name="lift")
    contact = scene.contacts[addition.contact]
    steps = AdditionOptions(addition.duration_s, addition.steps)
    _, grasp = plan_addition(setting, grasp, contact, steps, name="addition")
    return setting, grasp


def removal_instances(steps: int = 64) -> dict[str, RemovalProblem]:
    """Removals of every finger of every tool at two frictions, those that are possible at all.

    The paper's problem, without a bound on the rate of forces.
    """
    found: dict[str, RemovalProblem] = {}
    for name in SCENES:
        scene = load_scene(name)
        for scale in FRICTION_SCALES:
            try:
                setting, grasp = held_grasp(_with_friction(scene, scale))
            except PivotGaitError:
                continue
            for finger in FINGERS:
                staying = [each for key, each in grasp.fingers.items() if key != finger]
                options = RemovalOptions(1.6, steps)
                problem = removal_problem(setting, grasp, staying, grasp.fingers[finger], options)
                if smallest_turn(problem).feasible:
                    free = replace(problem, force_rate_max=np.inf)
                    found[f"{name}, {finger} leaves, friction x {scale}"] = free
    return found


def removal_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Removal at K = 64, cold and warm, against bare solvers; and its growth with K.

    All solve the same problems from the same start: the peers are the plain program, with exact
    Hessians made by CasADi, compiled once (their building time apart) and called without any of
    our packing, checks and clean-up. ``ours_s`` and ``peer_s`` are medians over the instances
    of the median over repetitions.
    """
    repeats = 3 if quick else 9
    problems = list(removal_instances().values())
    problems = problems[:: 2 if quick else 1]
    shape = (problems[0].steps, problems[0].staying, len(problems[0].clear_rise))
    name = f"removal, K = {shape[0]}"
    known = [solve_removal(each) for each in problems]
    changed = [_nudged(each) for each in problems]
    cold = [_median(partial(solve_removal, each), repeats) for each in problems]
    warm = [
        _median(partial(solve_removal, each, guess=near), repeats)
        for each, near in zip(changed, known, strict=True)
    ]
    rows = []
    for peer in ("fatrop", "ipopt"):
        began = perf_counter()
        solve = BareNlp(*shape, peer, warm=False)
        build = perf_counter() - began
        again = BareNlp(*shape, peer, warm=True)
        label = f"bare CasADi + {peer.upper()}"
        other = [_median(partial(solve, each), repeats) for each in problems]
        rows.append(_row(f"{name}, cold", cold, label, other, build))
        answers = [solve(each) for each in problems]
        other = [
            _median(partial(again, each, near), repeats)
            for each, near in zip(changed, answers, strict=True)
        ]
        rows.append(_row(f"{name}, warm", warm, label, other, build))
    doubled = [_median(partial(solve_with, each, "fatrop", doubling=True), 1) for each in problems]
    rows.append(_row(f"{name}, direct", cold, "the paper's doubling, from K = 8", doubled, None))
    rows.append(_growth(repeats, quick))
    return rows


class BareNlp:
    """The removal program handed to a solver as it is."""

    def __init__(
        self, steps: int, staying: int, clear_points: int, solver: NlpSolver, *, warm: bool
    ) -> None:
        import casadi as ca

        scale = SCALE_PER_STEP * steps
        program = removal_program(steps, staying, clear_points, rated=False, scale=scale)
        # expanded to scalar operations, which is CasADi's fastest way without our stage blocks
        options: dict[str, Any] = {"print_time": False, "expand": True, f"{solver}.print_level": 0}
        options |= {f"{solver}.tol": 1e-8, f"{solver}.max_iter": 500}
        if solver == "fatrop":
            options |= program.structure
        else:
            options["ipopt.sb"] = "yes"
        if warm:
            options[f"{solver}.mu_init"] = 1e-5
            if solver == "ipopt":
                options["ipopt.warm_start_init_point"] = "yes"
        self._nlpsol = ca.nlpsol("bare", solver, program.nlp.symbols, options)
        self._start = removal_nlp(steps, staying, clear_points).guess
        self._bounds: dict[str, Any] = {"lbg": 0.0, "ubg": ca.DM(program.nlp.upper)}

    def __call__(self, problem: RemovalProblem, answer: Any = None) -> Any:
        """Solve, from the common start or from an earlier answer; returns CasADi's answer."""
        start: dict[str, Any] = (
            {"x0": self._start(problem, None)}
            if answer is None
            else {"x0": answer["x"], "lam_g0": answer["lam_g"], "lam_x0": answer["lam_x"]}
        )
        return self._nlpsol(p=pack(problem), **start, **self._bounds)


def _nudged(problem: RemovalProblem) -> RemovalProblem:
    """A neighbour of a problem: contacts half a millimetre off, 1 % less friction."""
    shift = 5e-4 * np.ones(3)
    return replace(problem, points=problem.points + shift, friction=0.99 * problem.friction)


def _growth(repeats: int, quick: bool) -> dict[str, Any]:
    """Time from K = 32 to 256; the ratio is linear growth over ours."""
    times = {}
    for steps in (32, 256):
        problems = list(removal_instances(steps).values())[:: 6 if quick else 3]
        each = [_median(partial(solve_removal, p), max(repeats // 3, 2)) for p in problems]
        times[steps] = float(np.median(each))
    return {
        "name": "removal, K = 256, against 8 x the time of K = 32",
        "ours_s": times[256],
        "peer": "linear growth",
        "peer_s": 8.0 * times[32],
        "ratio": 8.0 * times[32] / times[256],
    }


def _row(name: str, ours: list[float], peer: str, other: list[float], build: float | None) -> Any:
    return {
        "name": name,
        "ours_s": float(np.median(ours)),
        "peer": peer,
        "peer_s": float(np.median(other)),
        "ratio": float(np.median(other) / np.median(ours)),
        "peer_build_s": build,
    }


def _median(call: Callable[[], Any], repeats: int) -> float:
    """Median time of a call [s], after one that warms caches."""
    call()
    times = []
    for _ in range(repeats):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return float(np.median(times))


def _with_friction(scene: Scene, scale: float) -> Scene:
    table = replace(scene.table, friction=scale * scene.table.friction)
    contacts = {
        name: replace(contact, friction=scale * contact.friction)
        for name, contact in scene.contacts.items()
    }
    return replace(scene, table=table, contacts=MappingProxyType(contacts))
