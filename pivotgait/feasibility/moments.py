"""Moments of a gait as grasps: what holds the tool then, and the load at that time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.dynamics import PivotingTool, required_wrench
from pivotgait.feasibility.grasps import Grasps, Index
from pivotgait.forces import AllocationProblem, LinearRows
from pivotgait.frozen import Array
from pivotgait.margins import phase_margins, smallest_of_phase
from pivotgait.models import HandleContact, Robot
from pivotgait.phases.torque_limits import torque_rows
from pivotgait.plans import PIVOT, Phase, RobotMotion, ToolMotion

SPARED = 0.999
"""Reserve of torque with which rows are made: so that weaker joints, too, have theirs."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Some moments of one phase.

    Attributes:
        phase: its name.
        time_s: (B,) from the phase's start [s].
        grasps: B grasps, with the whole friction: no reserve. A finger that comes or goes has the
            normal force that its ramp prescribes.
        torque_limits: whether the joints' torque limits are among the grasps' rows.
    """

    phase: str
    time_s: Array
    grasps: Grasps
    torque_limits: bool = False


def telling_samples(phase: Phase) -> Index:
    """Places of the middle of a phase, of its weakest moment by friction, and of its end."""
    margin = smallest_of_phase(phase_margins(phase), ("friction",))
    weakest = 0 if margin is None else int(np.argmin(np.abs(phase.time - margin.time_s)))
    last = len(phase.time) - 1
    return np.unique([last // 2, weakest, last])


def moments_of(phase: Phase, body: PivotingTool, robot: Robot | None = None) -> Moments:
    """The middle of a phase, its weakest moment by friction, and its end.

    Args:
        phase: with forces; with the robot's motion if there is a robot.
        body: the tool.
        robot: whose torque limits count too.
    """
    at = telling_samples(phase)
    motion = taken(phase.tool, at)
    names = (PIVOT, *(name for name in phase.contacts if name != PIVOT))
    tracks = [phase.contacts[name] for name in names]
    points = np.stack([track.world_point(phase.tool)[at] for track in tracks], axis=1)
    normals = np.stack([track.world_normal(phase.tool)[at] for track in tracks], axis=1)
    fixed = np.full((len(at), len(names)), np.nan)
    for place, track in enumerate(tracks):
        if phase.kind in ("removal", "addition") and track.name == phase.finger:
            force = np.sum(track.force[at] * normals[:, place], axis=1)
            fixed[:, place] = np.clip(force, 0.0, track.normal_max)
    rows = None
    if robot is not None and phase.robot is not None:
        fingers = [
            HandleContact(
                track.name,
                track.name,
                track.point,
                track.normal,
                track.friction,
                track.normal_min,
                track.normal_max,
            )
            for track in tracks[1:]
        ]
        rows = _every_joint(
            torque_rows(robot, taken(phase.robot, at), motion, fingers, reserve=SPARED)
        )
    count = len(at)
    problem = AllocationProblem(
        names=names,
        lever=points - motion.position[:, None],
        normals=normals,
        friction=np.array([track.friction for track in tracks]),
        normal_min=np.tile([track.normal_min for track in tracks], (count, 1)),
        normal_max=np.tile([track.normal_max for track in tracks], (count, 1)),
        wrench=required_wrench(body, motion),
        normal_fixed=fixed,
        rows=rows,
        objective="effort",
    )
    return Moments(phase.name, phase.time[at] - phase.time[0], Grasps.of(problem), rows is not None)


def _every_joint(rows: LinearRows) -> LinearRows:
    """Rows made with the reserve :data:`SPARED`, at the whole limits."""
    middle, half = 0.5 * (rows.lower + rows.upper), 0.5 * (rows.upper - rows.lower)
    whole = half / (1.0 - SPARED)
    return LinearRows(rows.matrix, middle - whole, middle + whole)


def taken(motion: Any, at: Index) -> Any:
    """A tool's or robot's motion at some samples."""
    kind = type(motion)
    assert kind in (ToolMotion, RobotMotion)
    return kind(**{name: value[at] for name, value in vars(motion).items()})
