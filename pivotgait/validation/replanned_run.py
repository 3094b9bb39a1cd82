"""A run whose plan is exchanged after each addition."""

from __future__ import annotations

from pivotgait.control.controller import Controller
from pivotgait.control.reference import Reference
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation.controllers import make_controller
from pivotgait.validation.moved_scene import gait_of
from pivotgait.validation.perturbation import Perturbation
from pivotgait.validation.replanning import Replan, Replanning, ReplanOptions
from pivotgait.validation.run import RunOptions, Timing, run
from pivotgait.validation.series import RunSeries


def run_replanned(
    plan: GaitPlan,
    scene: Scene,
    perturbation: Perturbation,
    options: RunOptions,
    replanning: ReplanOptions,
    *,
    hand: HandOptions | None = None,
) -> tuple[RunSeries, Timing, GaitPlan, tuple[Replan, ...]]:
    """Carry a plan out, the rest of it planned anew after each addition.

    Args:
        plan: with a robot.
        scene: of the plan.
        perturbation: how the world and the sensors differ from the plan.
        options: of the run.
        replanning: of the holds in which it is planned.
        hand: how the hand's motion is planned anew.

    Returns:
        The run, its times without those of planning, the plan as it was asked for moment by
        moment, holds included, and what became of each seam.

    Raises:
        InputError: a plan that is no whole gait of its scene.
        PivotGaitError: other bad input.
    """
    configs = scene.gaits[gait_of(plan, scene)]

    def law(reference: Reference) -> Controller:
        return make_controller(options.controller, reference, options.cycle_s)

    replanned = Replanning(plan, scene, configs, law, replanning, hand)
    series, timing = run(
        replanned.plan,
        scene,
        perturbation,
        options,
        controller=replanned.begin,
        duration=lambda: replanned.duration,
    )
    control_s = timing.control_s - replanned.plan_time_s / max(len(series.time), 1)
    timing = Timing(control_s, timing.simulator_s)
    return series, timing, replanned.plan, tuple(replanned.seams)
