"""Saves a grasp whose measured margins become small: forces anew, or the gait finger put back."""

from __future__ import annotations

import numpy as np

from pivotgait.control.grasp_monitor import GraspMonitor
from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.plan_clock import PlanClock
from pivotgait.control.put_back import PutBack
from pivotgait.control.reallocation import Reallocation
from pivotgait.control.recovery_event import RecoveryEvent
from pivotgait.control.recovery_options import RecoveryOptions
from pivotgait.control.reference import Instant
from pivotgait.control.task_controller import TaskController
from pivotgait.control.threshold import Threshold
from pivotgait.frozen import Array

_GONE_N = 1e-3
"""Forces that differ less from the planned ones count as planned."""


class RecoveringController:
    """A torque law with a guard: while no margin is small, torques are the law's, bit for bit.

    Where the least margin of the holding fingers and the orientation falls under a threshold,
    the planned forces are replaced, over a ramp, by an allocation for the measured tool. Where that
    of the normal forces and the orientation falls under a second one during a removal,
    :class:`PutBack` runs the plan backwards.

    Attributes:
        law: that makes the torques.
        options: thresholds.
        clock: the plan's time.
        monitor: of the margins.
        put_back: the second measure.
    """

    def __init__(self, law: TaskController, options: RecoveryOptions | None = None) -> None:
        """A guard of one run after another."""
        self.law, self.options = law, options or RecoveryOptions()
        options, reference = self.options, law.reference
        self.clock = PlanClock()
        self.monitor = GraspMonitor(
            reference, lag_s=options.lag_s, orientation_deg=options.orientation_deg
        )
        removals = tuple(p for p in reference.phases if p.samples.kind == "removal")
        self.put_back = PutBack(self.clock, removals, options)
        self._reallocation = Reallocation(reference, options.squeeze)
        self._weak = Threshold(options.reallocate_below, options.hysteresis, options.lasting_s)
        self.reset()

    def reset(self) -> None:
        """Start anew, before the first cycle of a run."""
        self.law.reset()
        self.clock.reset()
        self.monitor.reset()
        self.put_back.reset()
        self._weak.reset()
        self._allocations: list[RecoveryEvent] = []
        self._change: dict[str, Array] = {}
        self._target: dict[str, Array] = {}
        self._next_s = self._last_s = 0.0
        self.plan_time = 0.0

    @property
    def events(self) -> tuple[RecoveryEvent, ...]:
        """What was done so far, in the order of time."""
        return tuple(
            sorted((*self._allocations, *self.put_back.events), key=lambda each: each.time_s)
        )

    def is_over(self, time: float, hold_s: float) -> bool:
        """Whether the final grasp, or that of a removal given up, has been held for ``hold_s``."""
        since = self.put_back.given_up_s
        if since is not None:
            return time - since >= hold_s
        return self.clock.plan_time(time) >= self.law.reference.duration + hold_s

    def torque(self, measurement: Measurement) -> Array:
        """(n,) joint torques [N m] or [N]."""
        time = measurement.time
        self.clock.advance(time)
        self.plan_time = self.clock.plan_time(time)
        wanted = self.clock.instant(self.law.reference, time)
        task = self.law.tasks[wanted.phase]
        margins = self.monitor.margins(task, wanted, measurement)
        self.put_back.update(time, *margins.least(friction=self.options.cones_put_back))
        self._watch(time, *margins.least())
        if self._weak.on or self._change:
            wanted = self._changed(task, wanted, measurement)
        self._last_s = time
        return self.law.follow(wanted, measurement)

    def _watch(self, time: float, name: str, margin: float) -> None:
        was = self._weak.on
        if self._weak.update(margin, time) and not was:
            self._allocations.append(RecoveryEvent("reallocate", name, time, margin))
            self._next_s = time
        elif was and not self._weak.on:
            self._allocations[-1].end_s = time
        if was:
            self._allocations[-1].margin_after = margin

    def _changed(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Instant:
        """The plan with its forces on the way to those of the last allocation, or back."""
        time, none = measurement.time, np.zeros(3)
        if not self._weak.on:
            self._target = {}
        elif time >= self._next_s:
            self._next_s = time + self.options.period_s
            found = self._reallocation.forces(task, wanted, measurement.tool_rotation)
            more = () if found is None else found - wanted.force_in_tool
            self._target = dict(zip(task.finger_names, more, strict=False))
        share = min((time - self._last_s) / self.options.ramp_s, 1.0)
        kept = {}
        for name in {**self._change, **self._target}:
            now = self._change.get(name, none)
            now = now + share * (self._target.get(name, none) - now)
            if self._target or float(now @ now) > _GONE_N**2:
                kept[name] = now
        self._change = kept
        more = np.array([kept.get(name, none) for name in task.finger_names]).reshape(-1, 3)
        return wanted._replace(force_in_tool=wanted.force_in_tool + more)
