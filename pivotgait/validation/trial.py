"""One trial: perturb, plan again, run, judge."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field
from pathlib import Path

from pivotgait.exceptions import InputError, PivotGaitError
from pivotgait.gaits import plan_gait
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import Robot, Scene
from pivotgait.planning.posture_search import PostureOptions
from pivotgait.planning.problem import RelocationOptions
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_reader import plan_from_bytes
from pivotgait.validation.metrics import Metrics, measure
from pivotgait.validation.moved_scene import gait_of, moved, scene_of
from pivotgait.validation.perturbation import Perturbation, size_of_errors
from pivotgait.validation.planned import Planned, planned_at
from pivotgait.validation.replanned_run import run_replanned
from pivotgait.validation.replanning import Replan, ReplanOptions, in_phases_of
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
        plan_as_laid: whether a tool that lies elsewhere is planned for before the run; else it
            lies as planned.
        pivoting: whether the removal pivots the tool as planned; else the hand stands still, and
            the gait ends there (:func:`pivotgait.validation.without_pivoting.without_pivoting`).
        record_every: control cycles from one row of the record to the next.
        errors_up_to: every trial's errors are those of the scene's distributions times a factor
            of its own, uniform between 1 and this one (:func:`size_of_errors`).
        replanning: how the rest of the gait is planned anew during the run, after each addition;
            None for a run that keeps to its plan.
    """

    run: RunOptions = field(default_factory=RunOptions)
    perturbed: bool = True
    plan_as_laid: bool = True
    pivoting: bool = True
    record_every: int = 5
    errors_up_to: float = 1.0
    replanning: ReplanOptions | None = None

    def perturbation(self, scene: Scene, robot: Robot, seed: int) -> Perturbation:
        """What is otherwise in the trial of a seed.

        Raises:
            InputError: errors so large that no mass, friction or force reading is left.
        """
        if not self.perturbed:
            return Perturbation.none(robot, seed)
        draw = Perturbation.draw(scene.config.validation, robot, seed)
        if self.errors_up_to == 1.0:
            return draw
        return draw.enlarged(size_of_errors(seed, self.errors_up_to))


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
        plan_time_s: spent on planning for where the tool lies [s].
        seams: where the rest of the gait was planned anew during the run.
    """

    seed: int
    verdict: Verdict
    metrics: Metrics | None = None
    series: RunSeries | None = None
    planned: Planned | None = None
    timing: Timing | None = None
    plan_time_s: float = 0.0
    seams: tuple[Replan, ...] = ()


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
    perturbation = options.perturbation(scene, robot, seed)
    start = clock.perf_counter()
    if options.perturbed and options.plan_as_laid:
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


def check_replanning(options: TrialOptions) -> None:
    """Refuse what does not go together with planning anew under way.

    Raises:
        InputError: recovery, which changes the plan, too, or a gait that is cut short.
    """
    if options.replanning is None:
        return
    for other, given in (
        ("recovery", options.run.recovery is not None),
        ("a gait without pivoting", not options.pivoting),
    ):
        if given:
            what, mend = f"does not go together with {other}", "choose one of them"
            raise InputError(what, where="re-planning", mend=mend)


def _carry_out(
    plan: GaitPlan,
    scene: Scene,
    robot: Robot,
    perturbation: Perturbation,
    options: TrialOptions,
    plan_time_s: float,
) -> TrialResult:
    plan = carried_out(plan, scene, options)
    asked, seams = plan, tuple[Replan, ...]()
    if options.replanning is None:
        series, timing = run(plan, scene, perturbation, options.run)
    else:
        series, timing, asked, seams = run_replanned(
            plan, scene, perturbation, options.run, options.replanning, hand=PLANNING
        )
    planned = in_phases_of(plan, asked, planned_at(asked, series.followed, series.fingers))
    rows = series.every(options.record_every)
    return TrialResult(
        seed=perturbation.seed,
        verdict=judge(plan, robot, series, planned),
        metrics=measure(robot, series, planned),
        series=rows,
        planned=planned.every(options.record_every),
        timing=timing,
        plan_time_s=plan_time_s,
        seams=seams,
    )
