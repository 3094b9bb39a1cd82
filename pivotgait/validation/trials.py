"""Many trials: all counted, with a rate, its confidence, and where they failed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pivotgait.exceptions import InputError
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_writer import plan_to_bytes
from pivotgait.validation.controllers import check_controller
from pivotgait.validation.moved_scene import gait_of, scene_of
from pivotgait.validation.processes import run_jobs
from pivotgait.validation.simulator import check_simulator
from pivotgait.validation.trial import (
    TrialOptions,
    TrialResult,
    carried_out,
    check_replanning,
    run_trial,
)
from pivotgait.validation.verdict import Verdict, stage_names
from pivotgait.validation.wilson import wilson_interval

TIME_LIMIT_S = 300.0
"""Of one trial, planning included."""
_BEFORE_ANY_RUN = ("plan", "timeout", "crash")


@dataclass(frozen=True)
class Stage:
    """A phase or the final hold over all trials.

    Attributes:
        name: of the phase, or ``final_hold``.
        reached: trials that came so far.
        passed: trials that came through.
    """

    name: str
    reached: int
    passed: int


@dataclass(frozen=True, eq=False)
class TrialSet:
    """All trials of one plan with one controller.

    Attributes:
        options: of each.
        stages: in order.
        results: in the order of the seeds.
    """

    options: TrialOptions
    stages: tuple[Stage, ...]
    results: tuple[TrialResult, ...]

    @property
    def passed(self) -> int:
        """Number of trials that passed."""
        return sum(result.verdict.passed for result in self.results)

    @property
    def failures(self) -> dict[str, int]:
        """Number of failed trials by class, the most frequent first."""
        found = Counter(r.verdict.failure for r in self.results if not r.verdict.passed)
        return dict(found.most_common())

    def as_json(self) -> dict[str, Any]:
        """What ``pivotgait validate --json`` prints."""
        trials, replanning = len(self.results), self.options.replanning
        return {
            "simulator": self.options.run.simulator,
            "controller": self.options.run.controller,
            "perturbed": self.options.perturbed,
            "pivoting": self.options.pivoting,
            "replan_hold_s": replanning.hold_s if replanning else None,
            "trials": trials,
            "passed": self.passed,
            "rate": self.passed / trials if trials else 0.0,
            "wilson_95": list(wilson_interval(self.passed, trials)),
            "stages": [vars(stage).copy() for stage in self.stages],
            "failures": self.failures,
            "runs": [_run_json(result, self.options) for result in self.results],
        }


def run_trials(
    plan: GaitPlan,
    seeds: Sequence[int],
    options: TrialOptions | None = None,
    *,
    folder: Path | None = None,
    workers: int | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    progress: Callable[[TrialResult], None] | None = None,
) -> TrialSet:
    """Try a plan once with each seed, each trial in a process of its own.

    A trial's result depends on the plan, its seed and the options alone, not on the others or
    their order.

    Args:
        plan: with a robot.
        seeds: of the trials.
        options: of all of them.
        folder: in which the scene's relative URDF paths start.
        workers: processes at a time; as many as the machine lends us by default.
        time_limit_s: of each trial [s].
        progress: called with each result as it comes.

    Raises:
        InputError: a plan without a robot or with another than its scene's, an unknown or
            missing simulator or controller.
    """
    options = options or TrialOptions()
    check_simulator(options.run.simulator)
    check_controller(options.run.controller)
    check_replanning(options)
    scene = scene_of(plan, folder)
    if (options.perturbed and options.plan_as_laid) or options.replanning is not None:
        gait_of(plan, scene)
    if not seeds or min(seeds) < 0:
        raise InputError("no seeds, or a negative one", where="trials", mend="give seeds from 0")
    image = plan_to_bytes(plan)
    found: dict[int, TrialResult] = {}
    jobs = [(image, folder, seed, options) for seed in seeds]
    for outcome in run_jobs(run_trial, jobs, workers=workers, time_limit_s=time_limit_s):
        result = outcome.value
        if outcome.failure:
            verdict = Verdict(False, outcome.failure, detail=outcome.detail)
            result = TrialResult(seeds[outcome.place], verdict)
        found[outcome.place] = result
        if progress:
            progress(result)
    results = tuple(found[place] for place in range(len(seeds)))
    stages = stages_of(carried_out(plan, scene, options), results)
    return TrialSet(options, stages, results)


def stages_of(plan: GaitPlan, results: Sequence[TrialResult]) -> tuple[Stage, ...]:
    """How many trials reached and passed each stage; one that never ran reached none."""
    names = stage_names(plan)
    ends = [_completed(result.verdict, names) for result in results]
    return tuple(
        Stage(name, _count(ends, place, _failed_before_any(results)), sum(e > place for e in ends))
        for place, name in enumerate(names)
    )


def _count(ends: Sequence[int], place: int, never: int) -> int:
    """Trials that came to a stage: those through all before it, but for those never begun."""
    return sum(end >= place for end in ends) - (never if place == 0 else 0)


def _failed_before_any(results: Sequence[TrialResult]) -> int:
    return sum(result.verdict.failure in _BEFORE_ANY_RUN for result in results)


def _completed(verdict: Verdict, names: Sequence[str]) -> int:
    """Number of stages a trial came through."""
    if verdict.passed:
        return len(names)
    return names.index(verdict.stage) if verdict.stage else 0


def _run_json(result: TrialResult, options: TrialOptions) -> dict[str, Any]:
    verdict, timing = result.verdict, result.timing
    events = result.series.recovery if result.series else ()
    guarded, replanning = options.run.recovery is not None, options.replanning is not None
    recovery = {"recovery": [each.as_json() for each in events]} if guarded else {}
    replanned = {"replans": [seam.as_json() for seam in result.seams]} if replanning else {}
    return {
        "seed": result.seed,
        "passed": verdict.passed,
        "failure": verdict.failure or None,
        "stage": verdict.stage or None,
        "time_s": verdict.time_s if verdict.stage else None,
        "detail": verdict.detail,
        "metrics": result.metrics.as_json() if result.metrics else {},
        **recovery,
        "plan_time_s": result.plan_time_s,
        **replanned,
        "control_cycle_s": timing.control_s if timing else None,
        "simulator_cycle_s": timing.simulator_s if timing else None,
    }
