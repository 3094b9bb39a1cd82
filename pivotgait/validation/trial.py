"""One trial: perturb, plan again, run, judge."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field
from pathlib import Path

from pivotgait.exceptions import PivotGaitError
from pivotgait.gaits import plan_gait
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import Robot, Scene
from pivotgait.planning.posture_search import PostureOptions
from pivotgait.planning.problem import RelocationOptions
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_reader import plan_from_bytes
from pivotgait.validation.metrics import Metrics, measure
from pivotgait.validation.moved_scene import gait_of, moved, scene_of
from pivotgait.validation.perturbation import Perturbation
from pivotgait.validation.planned import Planned, planned_at
from pivotgait.validation.run import RunOptions, Timing, run
from pivotgait.validation.series import RunSeries
from pivotgait.validation.verdict import Verdict, judge
from pivotgait.validation.without_pivoting import without_pivoting

_NEVER_S = 1e9
PLANNING = HandOptions(
    postures=PostureOptions(starts=400, time_limit_s=_NEVER_S),
    relocation=RelocationOptions(max_iterations=5_000, time_limit_s=_NEVER_S),
)
"""Limits that are counted, not timed: a busy machine plans as an idle one. A trial's process
has a time limit of its own."""


@dataclass(frozen=True)
class TrialOptions:
    """What all trials of a set have in common.

    Attributes:
        run: how each is carried out.
        perturbed: whether world and sensors differ from the plan; else the run is nominal.
        replan: whether a tool that lies elsewhere is planned for; else it lies as planned.
        pivoting: whether the removal pivots the tool as planned; else the hand stands still, and
            the gait ends there (:func:`pivotgait.validation.without_pivoting.without_pivoting`).
        record_every: control cycles from one row of the record to the next.
    """

    run: RunOptions = field(default_factory=RunOptions)
    perturbed: bool = True
    replan: bool = True
    pivoting: bool = True
    record_every: int = 5


@dataclass(frozen=True, eq=False)
class TrialResult:
    """What a trial leaves behind.

    Attributes:
        seed: of the trial.
        verdict: on the run; a trial may also fail by ``plan``, ``timeout`` or ``crash``.
        metrics: None without a run.
        series: some rows of the run, None without one.
        planned: the plan at those rows.
        timing: None without a run.
        plan_time_s: spent on planning again [s].
    """

    seed: int
    verdict: Verdict
    metrics: Metrics | None = None
    series: RunSeries | None = None
    planned: Planned | None = None
    timing: Timing | None = None
    plan_time_s: float = 0.0


def run_trial(image: bytes, folder: Path | None, seed: int, options: TrialOptions) -> TrialResult:
    """One trial from a plan file's bytes; made for a process of its own.

    Args:
        image: of the plan file.
        folder: in which the scene's relative URDF paths start.
        seed: of the perturbation and the sensors' noise.
        options: of the set.

    Raises:
        PivotGaitError: bad input; a plan that cannot be made is a failed trial.
    """
    plan = plan_from_bytes(image, where="plan")
    scene = scene_of(plan, folder)
    robot = scene.robot
    assert robot is not None  # `scene_of` refuses a scene without
    if not options.perturbed:
        return _carry_out(plan, scene, robot, Perturbation.none(robot, seed), options, 0.0)
    perturbation = Perturbation.draw(scene.config.validation, robot, seed)
    start = clock.perf_counter()
    if options.replan:
        name = gait_of(plan, scene)
        try:
            scene = moved(scene, perturbation.laid, folder)
            plan = plan_gait(scene, gait=name, seed=plan.seed, like=plan, options=PLANNING)
        except PivotGaitError as error:
            return TrialResult(seed, Verdict(False, "plan", detail=str(error)))
    spent = clock.perf_counter() - start
    return _carry_out(plan, scene, robot, perturbation, options, spent)


def carried_out(plan: GaitPlan, scene: Scene, options: TrialOptions) -> GaitPlan:
    """The plan, or as much of it as is done without pivoting.

    Raises:
        InputError: without pivoting, for a plan without a removal.
    """
    return plan if options.pivoting else without_pivoting(plan, scene)


def _carry_out(
    plan: GaitPlan,
    scene: Scene,
    robot: Robot,
    perturbation: Perturbation,
    options: TrialOptions,
    plan_time_s: float,
) -> TrialResult:
    plan = carried_out(plan, scene, options)
    series, timing = run(plan, scene, perturbation, options.run)
    planned = planned_at(plan, series.time, series.fingers)
    rows = series.every(options.record_every)
    return TrialResult(
        seed=perturbation.seed,
        verdict=judge(plan, robot, series, planned),
        metrics=measure(robot, series, planned),
        series=rows,
        planned=planned_at(plan, rows.time, rows.fingers),
        timing=timing,
        plan_time_s=plan_time_s,
    )
