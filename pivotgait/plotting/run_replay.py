"""A run in the form of a plan, so that whatever shows plans can show runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array
from pivotgait.plans.plan import GaitPlan, Phase, RobotMotion, ToolMotion
from pivotgait.plotting.timeline import spans
from pivotgait.validation.record_reading import RecordedMotion


def replay(plan: GaitPlan, motion: RecordedMotion) -> GaitPlan:
    """The phases that a run came to, with its places, joints and forces at the plan's times.

    Contacts keep the points, normals and coefficients of the plan; of velocities and
    accelerations, which no picture shows, those of the tool stay the plan's and those of the
    joints are the run's and zero. The result has no certificate: it is no plan.
    """
    end = float(motion.series.time[-1])
    phases = []
    for span in spans(plan):
        reached = int(np.count_nonzero(span.time <= end))
        if reached >= 2:
            rows = slice(0, reached)
            tool = _samples(span.phase.tool, rows)
            shortened = replace(span.phase, time=span.phase.time[rows], tool=tool)
            phases.append(_as_run(shortened, motion, span.time[rows]))
    return replace(plan, phases=tuple(phases), certificate=None)


def held(plan: GaitPlan, motion: RecordedMotion) -> Phase | None:
    """The last instant of a run's final hold as a phase of one sample; None if it has none."""
    last, end = plan.phases[-1], float(motion.series.time[-1])
    if end <= spans(plan)[-1].end:
        return None
    tool = _samples(last.tool, slice(-1, None))
    return _as_run(replace(last, time=np.zeros(1), tool=tool), motion, np.array([end]))


def _samples(motion: ToolMotion, rows: slice) -> ToolMotion:
    return ToolMotion(**{name: values[rows] for name, values in vars(motion).items()})


def _as_run(phase: Phase, motion: RecordedMotion, at: Array) -> Phase:
    """A phase with the run's rows at times ``at`` (n,) since the plan's start [s]."""
    series = motion.series

    def between(values: Array) -> Array:
        columns = [np.interp(at, series.time, column) for column in values.T]
        return np.stack(columns, axis=-1)

    turn = Slerp(series.time, Rotation.from_quat(series.tool_orientation))
    inside = np.clip(at, series.time[0], series.time[-1])
    tool = replace(
        phase.tool,
        position=between(series.tool_position),
        orientation=turn(inside).as_quat(),
    )
    contacts = {}
    for name, track in phase.contacts.items():
        if track.is_pivot:
            contacts[name] = replace(track, force=between(series.pivot_force))
        elif name in series.fingers:
            place = series.fingers.index(name)
            contacts[name] = replace(track, force=between(series.force[:, place]))
    q, v, tau = (between(each) for each in (series.q, series.v, series.tau))
    robot = RobotMotion(q, v, np.zeros_like(q), tau)
    return replace(phase, tool=tool, contacts=contacts, robot=robot)
