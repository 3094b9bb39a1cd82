"""One plan in two engines: the nominal run, causes of differences, and perturbed trials."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pivotgait.exceptions import InputError
from pivotgait.plans import GaitPlan
from pivotgait.validation.agreement import Agreement, Tolerances
from pivotgait.validation.agreement_causes import CHANGES, Causes, look_for_cause
from pivotgait.validation.agreement_trials import TrialAgreement
from pivotgait.validation.comparing import CarriedOut, compare_runs
from pivotgait.validation.controllers import check_controller
from pivotgait.validation.moved_scene import scene_of
from pivotgait.validation.record import plan_digest
from pivotgait.validation.run import RunOptions
from pivotgait.validation.simulator import SimulatorOptions, check_simulator
from pivotgait.validation.trial import TrialOptions, TrialResult
from pivotgait.validation.trials import TrialSet, run_trials

SCHEMA = "pivotgait-comparison/1"


@dataclass(frozen=True)
class CompareOptions:
    """How two engines are compared.

    Attributes:
        simulators: names.
        run: of both but for the simulator.
        trials: number of perturbed trials in each after the nominal run.
        seed: of the nominal run's noise and of the first trial.
        causes: whether causes are looked for; None for: if the engines do not agree.
        tolerances: of the comparison.
        workers: processes at a time; as many as the machine lends us by default.
    """

    simulators: tuple[str, str] = ("pybullet", "mujoco")
    run: RunOptions = field(default_factory=RunOptions)
    trials: int = 0
    seed: int = 0
    causes: bool | None = None
    tolerances: Tolerances = field(default_factory=Tolerances)
    workers: int | None = None

    @property
    def most_runs(self) -> int:
        """Runs and trials that may be made."""
        repeats = 0 if self.causes is False else len(CHANGES)
        return 2 * (1 + repeats + self.trials)

    def __post_init__(self) -> None:
        if self.simulators[0] == self.simulators[1]:
            mend = "name two"
            raise InputError("an engine agrees with itself", where="simulators", mend=mend)
        if self.trials < 0:
            raise InputError(f"{self.trials} trials", where="comparison", mend="give 0 or more")


@dataclass(frozen=True, eq=False)
class Comparison:
    """What became of one plan in two engines.

    Attributes:
        plan: digest of its file.
        nominal: the nominal run in each engine.
        agreement: of the nominal runs.
        causes: None where none were looked for.
        trials: None without perturbed trials.
    """

    plan: str
    nominal: tuple[TrialResult, TrialResult]
    agreement: Agreement
    causes: Causes | None
    trials: TrialAgreement | None

    def as_json(self) -> dict[str, Any]:
        """What ``pivotgait compare --json`` prints."""
        return {
            "schema": SCHEMA,
            "plan_sha256": self.plan,
            "nominal": self.agreement.as_json(),
            "causes": self.causes.as_json() if self.causes else None,
            "trials": self.trials.as_json() if self.trials else None,
        }


def compare_engines(
    plan: GaitPlan,
    options: CompareOptions | None = None,
    *,
    folder: Path | None = None,
    progress: Callable[[], None] | None = None,
) -> Comparison:
    """Carry a plan out in two engines with the same controller, seeds and perturbations.

    Args:
        plan: with a robot.
        options: of the comparison.
        folder: in which the scene's relative URDF paths start.
        progress: called after each run and trial.

    Raises:
        InputError: bad input; a simulator that is not installed, before anything is run.
        UnknownNameError: no such simulator or controller.
    """
    options = options or CompareOptions()
    for name in options.simulators:
        check_simulator(name)
    check_controller(options.run.controller)
    pair = _Pair(plan, options, folder, progress)
    nominal = pair.nominal(options.run.engine)
    found = pair.agreement(nominal)
    causes = None
    if options.causes or (options.causes is None and not found.agrees):
        causes = look_for_cause(found, options.run.engine, pair.again)
    trials = pair.trials() if options.trials else None
    return Comparison(plan_digest(plan), nominal, found, causes, trials)


@dataclass(frozen=True)
class _Pair:
    """Both engines, ready to be asked."""

    plan: GaitPlan
    options: CompareOptions
    folder: Path | None
    progress: Callable[[], None] | None

    def again(self, engine: SimulatorOptions) -> Agreement:
        return self.agreement(self.nominal(engine))

    def nominal(self, engine: SimulatorOptions) -> tuple[TrialResult, TrialResult]:
        """The nominal run in each, every control cycle of it."""
        seeds = range(self.options.seed, self.options.seed + 1)
        one, two = (
            self._try(name, engine, seeds, perturbed=False, record_every=1).results[0]
            for name in self.options.simulators
        )
        return one, two

    def trials(self) -> TrialAgreement:
        """The perturbed trials in each."""
        engine, first = self.options.run.engine, self.options.seed
        seeds = range(first, first + self.options.trials)
        one, two = (
            self._try(name, engine, seeds, perturbed=True, record_every=20)
            for name in self.options.simulators
        )
        return TrialAgreement((one, two))

    def agreement(self, nominal: tuple[TrialResult, TrialResult]) -> Agreement:
        robot = scene_of(self.plan, self.folder).robot
        assert robot is not None  # `scene_of` refuses a scene without
        one, two = (
            _carried_out(name, result)
            for name, result in zip(self.options.simulators, nominal, strict=True)
        )
        options = self.options
        return compare_runs(
            self.plan,
            robot,
            one,
            two,
            controller=options.run.controller,
            tolerances=options.tolerances,
        )

    def _try(
        self,
        simulator: str,
        engine: SimulatorOptions,
        seeds: range,
        *,
        perturbed: bool,
        record_every: int,
    ) -> TrialSet:
        run = replace(self.options.run, simulator=simulator, engine=engine)
        progress = self.progress
        return run_trials(
            self.plan,
            seeds,
            TrialOptions(run, perturbed=perturbed, record_every=record_every),
            folder=self.folder,
            workers=self.options.workers,
            progress=(lambda _: progress()) if progress else None,
        )


def _carried_out(simulator: str, result: TrialResult) -> CarriedOut:
    if result.series is None:
        found = result.verdict
        what = f"the nominal run failed by {found.failure}: {found.detail}"
        raise InputError(what, where=simulator, mend="look into it with 'pivotgait validate'")
    return CarriedOut(simulator, result.series, result.verdict)
