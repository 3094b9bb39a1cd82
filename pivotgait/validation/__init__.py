"""Closed-loop trials: another physics engine carries a plan out and a stated rule judges it."""

from pivotgait.validation.metrics import Metrics
from pivotgait.validation.perturbation import ForceSensing, Perturbation
from pivotgait.validation.record import RecordError, plan_digest, read_summary, write_record
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
    "FAILURES",
    "FINAL_HOLD",
    "ForceSensing",
    "Metrics",
    "Perturbation",
    "RecordError",
    "Rule",
    "RunOptions",
    "RunSeries",
    "Simulator",
    "SimulatorOptions",
    "SimulatorState",
    "Stage",
    "Timing",
    "TrialOptions",
    "TrialResult",
    "TrialSet",
    "Verdict",
    "World",
    "judge",
    "make_simulator",
    "plan_digest",
    "read_summary",
    "run",
    "run_trial",
    "run_trials",
    "wilson_interval",
    "write_record",
]
