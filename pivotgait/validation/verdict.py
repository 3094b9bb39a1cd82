"""Whether a run succeeded, by a stated rule, and why not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.plans import GaitPlan
from pivotgait.validation.planned import Planned
from pivotgait.validation.series import RunSeries
from pivotgait.validation.slips import fingertip_slips, tip_slip

Flags = NDArray[np.bool_]

FINAL_HOLD = "final_hold"
"""Name of the stage after the plan's last phase."""
FAILURES = ("slip", "loss", "roll-out", "limit", "collision", "divergence", "put-back")
"""Classes of failures in a run; a trial may also fail by ``plan``, ``timeout`` and ``crash``.

``put-back``: the tool was held by all rules, but a removal was given up and its finger put back.
"""


@dataclass(frozen=True)
class Rule:
    """When a run counts as a success.

    Every phase and the final hold are completed, and until then:

    Attributes:
        lost_s: no contact that must hold is without force for longer [s].
        tip_slip_m: the tip stays within this of where the plan began [m], on the table.
        fingertip_slip_m: every holding fingertip moves less along the tool's surface [m].
        orientation_deg: the tool stays within this of the planned orientation [deg].
        limit_rad: no joint is farther beyond its limits [rad] or [m].
        saturated_s: no joint is asked for more than its largest torque for longer [s].
        table_m: the table bears the tool elsewhere than at the tip only while the plan keeps it
            lower than this [m].
        carried_m: a tool that is taken off the table moves within this of the planned way [m].
        release_s: a finger that leaves or comes may touch for so long after leaving and before
            coming [s]; else nothing touches that should not.
    """

    lost_s: float = 0.020
    tip_slip_m: float = 3e-3
    fingertip_slip_m: float = 3e-3
    orientation_deg: float = 5.0
    limit_rad: float = 0.01
    saturated_s: float = 0.020
    table_m: float = 3e-3
    carried_m: float = 5e-3
    release_s: float = 0.25


@dataclass(frozen=True)
class Verdict:
    """What the rule says of a run.

    Attributes:
        passed: whether it is a success.
        failure: class of the first failure, empty if there is none.
        stage: name of the phase it happened in, or of the final hold.
        time_s: since the plan's start [s].
        detail: what happened, with the offending value.
    """

    passed: bool
    failure: str = ""
    stage: str = ""
    time_s: float = 0.0
    detail: str = ""


@dataclass(frozen=True)
class _Event:
    time: float
    failure: str
    detail: str


def stage_names(plan: GaitPlan) -> tuple[str, ...]:
    """The plan's phases and the final hold. Closing the fingers belongs to the first phase."""
    return (*(phase.name for phase in plan.phases), FINAL_HOLD)


def judge(
    plan: GaitPlan, robot: Robot, series: RunSeries, planned: Planned, rule: Rule | None = None
) -> Verdict:
    """The verdict on a run.

    Args:
        plan: that was carried out.
        robot: of the plan.
        series: of the run.
        planned: the plan at the run's times.
        rule: the default if not given.
    """
    rule = rule or Rule()
    events = [
        *_slips(robot, series, planned, rule),
        *_losses(series, planned, rule),
        *_drops(series, planned, rule),
        *_turns(series, planned, rule),
        *_limits(robot, series, rule),
        *_touches(series, planned, rule),
    ]
    if series.diverged:
        events.append(_Event(float(series.time[-1]), "divergence", series.diverged))
    if not events:
        events = _put_back(plan, series, planned)
    if not events:
        return Verdict(passed=True)
    first = min(events, key=lambda event: event.time)
    names = stage_names(plan)
    place = int(planned.phase[np.searchsorted(series.time, first.time)])
    return Verdict(
        False, first.failure, names[min(place, len(names) - 1)], first.time, first.detail
    )


def orientation_errors(series: RunSeries, planned: Planned) -> Array:
    """(N,) angles between the real and the planned orientation [rad]."""
    real = Rotation.from_quat(series.tool_orientation)
    return np.asarray((planned.rotation.inv() * real).magnitude())


def _put_back(plan: GaitPlan, series: RunSeries, planned: Planned) -> list[_Event]:
    """A run with recovery that ended before its plan; phases done late count as completed."""
    if series.plan_time is None or planned.phase[-1] >= len(plan.phases):
        return []
    # The clock comes a cycle too far before it stands: the stage is the one in which it stands.
    elsewhere = np.flatnonzero(planned.phase != planned.phase[-1])
    stands = float(series.time[elsewhere[-1] + 1]) if len(elsewhere) else float(series.time[0])
    when = max((stands, *(each.time_s for each in series.recovery)))
    return [_Event(when, "put-back", "recovered, not completed")]


def _slips(robot: Robot, series: RunSeries, planned: Planned, rule: Rule) -> list[_Event]:
    on_table = planned.carried == 0.0
    slips = {"tip": (np.where(on_table, tip_slip(series), 0.0), rule.tip_slip_m)}
    for name, slip in fingertip_slips(robot, series, planned).items():
        slips[name] = (slip, rule.fingertip_slip_m)
    return [
        _Event(float(series.time[row]), "slip", f"{name} slipped {1e3 * limit:g} mm")
        for name, (slip, limit) in slips.items()
        if (row := _first(slip >= limit)) is not None
    ]


def _losses(series: RunSeries, planned: Planned, rule: Rule) -> list[_Event]:
    """A contact without force for too long, from the plan's start on."""
    begun = series.time >= 0.0
    contacts = {
        name: (series.force[:, k], planned.holds[:, k] > 0.0)
        for k, name in enumerate(series.fingers)
    }
    contacts["pivot"] = (series.pivot_force, planned.carried == 0.0)
    events = []
    for name, (force, wanted) in contacts.items():
        lost = wanted & begun & ~np.any(force != 0.0, axis=1)
        when = _lasting(series.time, lost, rule.lost_s)
        if when is not None:
            what = f"{name} lost its contact for more than {1e3 * rule.lost_s:g} ms"
            events.append(_Event(when, "loss", what))
    return events


def _drops(series: RunSeries, planned: Planned, rule: Rule) -> list[_Event]:
    """A tool taken off the table that does not go where it should: up, and nowhere else."""
    rows = np.flatnonzero(planned.carried > 0.0)
    if not len(rows):
        return []
    way = series.tool_position[rows] - series.tool_position[rows[0]]
    way[:, 2] -= planned.rise[rows]
    row = _first(np.asarray(np.linalg.norm(way, axis=1) > rule.carried_m, dtype=np.bool_))
    if row is None:
        return []
    what = f"the carried tool is {1e3 * rule.carried_m:g} mm off its way"
    return [_Event(float(series.time[rows[row]]), "loss", what)]


def _turns(series: RunSeries, planned: Planned, rule: Rule) -> list[_Event]:
    apart = orientation_errors(series, planned)
    row = _first(np.asarray(apart > np.radians(rule.orientation_deg), dtype=np.bool_))
    if row is None:
        return []
    what = f"the tool turned {rule.orientation_deg:g} degrees away from the plan"
    return [_Event(float(series.time[row]), "roll-out", what)]


def _limits(robot: Robot, series: RunSeries, rule: Rule) -> list[_Event]:
    events = []
    beyond: Flags = robot.beyond_range(series.q) > rule.limit_rad
    row = _first(np.any(beyond, axis=1))
    if row is not None:
        joint = series.joint_names[int(np.argmax(beyond[row]))]
        events.append(_Event(float(series.time[row]), "limit", f"{joint} is beyond its limits"))
    for k, joint in enumerate(series.joint_names):
        over = np.abs(series.tau[:, k]) > robot.effort_max[k]
        when = _lasting(series.time, over & (series.time >= 0.0), rule.saturated_s)
        if when is not None:
            events.append(_Event(when, "limit", f"{joint} needs more than its largest torque"))
    return events


def _touches(series: RunSeries, planned: Planned, rule: Rule) -> list[_Event]:
    events = [
        _Event(float(times[0]), "collision", f"{pair} touch")
        for pair, times in series.touches.items()
    ]
    rows = np.searchsorted(series.time, series.touching_table)
    high = np.flatnonzero(planned.height[rows] > rule.table_m)
    if len(high):
        time = float(series.touching_table[high[0]])
        events.append(_Event(time, "collision", "table - tool touch beside the tip"))
    for k, name in enumerate(series.fingers):
        touching: Flags = np.any(series.force[:, k] != 0.0, axis=1)
        row = _first(touching & _well_inside(series.time, planned.free[:, k] > 0, rule.release_s))
        if row is not None:
            what = f"{name} touches the tool while it is free"
            events.append(_Event(float(series.time[row]), "collision", what))
    return events


def _first(bad: Flags) -> int | None:
    rows = np.flatnonzero(bad)
    return int(rows[0]) if len(rows) else None


def _spans(on: Flags) -> list[tuple[int, int]]:
    """First and last row of each unbroken run of truth."""
    padded = np.concatenate(([0], np.asarray(on, dtype=int), [0]))
    edges = np.diff(padded)
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def _lasting(time: Array, on: Flags, limit: float) -> float | None:
    """When something was on for longer than ``limit`` [s] for the first time."""
    for start, end in _spans(on):
        if time[end] - time[start] > limit:
            return float(time[start])
    return None


def _well_inside(time: Array, on: Flags, margin: float) -> Flags:
    """Where ``on`` holds, but for a margin [s] at each change during the run."""
    inside = np.zeros(len(time), dtype=bool)
    for start, end in _spans(on):
        left = time[start] + margin * (start > 0)
        right = time[end] - margin * (end < len(time) - 1)
        inside |= (time >= left) & (time <= right)
    return inside
