"""A control law with or without recovery, and when its run is over."""

from __future__ import annotations

from dataclasses import replace

from pivotgait.control import Controller, RecoveringController, RecoveryOptions
from pivotgait.control.task_controller import TaskController
from pivotgait.exceptions import InputError
from pivotgait.validation.series import RunSeries

MOST_LATE = 3.0
"""A run with recovery ends after so many times its length at the latest."""


def guarded(law: Controller, options: RecoveryOptions | None) -> Controller:
    """The law, guarded if options are given.

    Raises:
        InputError: a law whose forces cannot be changed.
    """
    if options is None:
        return law
    if not isinstance(law, TaskController):
        raise InputError(
            "this control law does not recover",
            where="controller",
            mend="use hybrid or feedforward, or no recovery",
        )
    return RecoveringController(law, options)


def most_cycles(law: Controller, cycles: int) -> int:
    """Cycles after which a run of ``cycles`` as planned is broken off."""
    return round(MOST_LATE * cycles) if isinstance(law, RecoveringController) else cycles


def plan_time(law: Controller, before_s: float) -> float | None:
    """Time of the plan that a law with a clock of its own followed in the last cycle [s].

    Args:
        law: of the run.
        before_s: time of the reference that is before the plan's start [s].
    """
    return law.plan_time - before_s if isinstance(law, RecoveringController) else None


def is_over(law: Controller, time: float, hold_s: float) -> bool:
    """Whether a law with a clock of its own is done at the run's ``time`` [s]."""
    return isinstance(law, RecoveringController) and law.is_over(time, hold_s)


def with_events(series: RunSeries, law: Controller, before_s: float) -> RunSeries:
    """The series with what the law did to save the grasp, times since the plan's start."""
    if not isinstance(law, RecoveringController):
        return series
    events = tuple(each.since(before_s) for each in law.events)
    return replace(series, recovery=events)
