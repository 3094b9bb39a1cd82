"""Closed-loop trials: another physics engine carries a plan out and a stated rule judges it."""

from pivotgait.validation.agreement import Agreement, Tolerances
from pivotgait.validation.baselines import BASELINES, Baseline, run_baselines
from pivotgait.validation.comparing import CarriedOut, compare_runs
from pivotgait.validation.comparison import CompareOptions, Comparison, compare_engines
from pivotgait.validation.metrics import Metrics
from pivotgait.validation.perturbation import ForceSensing, Perturbation
from pivotgait.validation.record import RecordError, plan_digest, read_summary, write_record
from pivotgait.validation.replanning import Replan, ReplanOptions
from pivotgait.validation.run import RunOptions, Timing, run
from pivotgait.validation.series import RunSeries
from pivotgait.validation.simulator import (
    Simulator,
    SimulatorOptions,
    SimulatorState,
    make_simulator,
)
from pivotgait.validation.trial import TrialOptions, TrialResult, run_trial
from pivotgait.validation.trials import Stage, TrialSet, run_trials
from pivotgait.validation.verdict import FAILURES, FINAL_HOLD, Rule, Verdict, judge
from pivotgait.validation.wilson import wilson_interval
from pivotgait.validation.world import World

__all__ = [
    "BASELINES",
    "FAILURES",
    "FINAL_HOLD",
    "Agreement",
    "Baseline",
    "CarriedOut",
    "CompareOptions",
    "Comparison",
    "ForceSensing",
    "Metrics",
    "Perturbation",
    "RecordError",
    "Replan",
    "ReplanOptions",
    "Rule",
    "RunOptions",
    "RunSeries",
    "Simulator",
    "SimulatorOptions",
    "SimulatorState",
    "Stage",
    "Timing",
    "Tolerances",
    "TrialOptions",
    "TrialResult",
    "TrialSet",
    "Verdict",
    "World",
    "compare_engines",
    "compare_runs",
    "judge",
    "make_simulator",
    "plan_digest",
    "read_summary",
    "run",
    "run_baselines",
    "run_trial",
    "run_trials",
    "wilson_interval",
    "write_record",
]
