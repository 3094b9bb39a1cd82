"""When contacts were made and broken in a run, and when the plan wanted it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan, Phase
from pivotgait.validation.planned import Planned
from pivotgait.validation.series import RunSeries

Flags = NDArray[np.bool_]

BEARS_N = 0.1
"""A fingertip bears while its force exceeds this; below, simulated contacts chatter."""


@dataclass(frozen=True)
class ContactEvent:
    """A finger that comes to the tool or leaves it, in a phase that says so.

    Attributes:
        phase: name.
        finger: name.
        kind: ``make`` or ``break``.
        planned_s: when the planned force passes 0.1 N, since the plan's start [s].
        actual_s: the same of the run; None if the force never got there.
        planned_rate_N_s: by which the planned force grows or shrinks in the phase, on average: a
            difference of forces of 0.1 N shifts the instant by 0.1 N over it.
    """

    phase: str
    finger: str
    kind: Literal["make", "break"]
    planned_s: float
    actual_s: float | None
    planned_rate_N_s: float


def contact_events(plan: GaitPlan, series: RunSeries, planned: Planned) -> tuple[ContactEvent, ...]:
    """The contacts of a run that its plan makes or breaks, in the plan's order.

    A contact is made at the first row of its phase at which the fingertip bears more than 0.1 N,
    and broken at the last one. Phases that the run did not complete are left out; times are as
    fine as the rows of ``series``.

    Args:
        plan: that was carried out.
        series: of the run.
        planned: the plan at its rows.
    """
    events, start = [], 0.0
    for phase in plan.phases:
        end = start + phase.duration_s
        changes = phase.kind in ("addition", "removal") and phase.finger in series.fingers
        if changes and series.time[-1] >= end:
            rows = (series.time >= start) & (series.time <= end)
            events.append(_event(phase, series, planned, rows))
        start = end
    return tuple(events)


def _event(phase: Phase, series: RunSeries, planned: Planned, rows: Flags) -> ContactEvent:
    place = series.fingers.index(phase.finger)
    time = series.time[rows]
    size = np.linalg.norm(planned.force[rows, place], axis=-1)
    rate = float((size.max() - size.min()) / phase.duration_s)
    makes = phase.kind == "addition"
    wanted = _crossing(time, size, first=makes)
    real = _crossing(time, np.linalg.norm(series.force[rows, place], axis=-1), first=makes)
    edge = float(time[0] if makes else time[-1])
    kind: Literal["make", "break"] = "make" if makes else "break"
    expected = edge if wanted is None else wanted
    return ContactEvent(phase.name, phase.finger, kind, expected, real, rate)


def _crossing(time: Array, force: Array, *, first: bool) -> float | None:
    """First or last time [s] at which a force (N,) bears."""
    bearing = np.flatnonzero(force > BEARS_N)
    return float(time[bearing[0 if first else -1]]) if len(bearing) else None
