"""Forces that turn the tool back to its plan: the measured pose closes the outer loop."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite

import numpy as np
import pinocchio as pin

from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array

_LEAST_LEVER = 0.02
"""Levers below this length [m] hardly count: damping of the distribution."""


@dataclass(frozen=True)
class ToolGains:
    """Gains of the moment about the pivot that turns the tool back.

    Attributes:
        stiffness: moment per angle [N m/rad].
        damping: moment per angular velocity [N m s/rad].
        share: largest correction of a finger's force over its planned normal force.
    """

    stiffness: float = 3.0
    damping: float = 0.05
    share: float = 0.25

    def __post_init__(self) -> None:
        """Refuse gains that are negative or no numbers."""
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (isfinite(value) and value >= 0.0):
                raise InputError(f"gain {entry.name} = {value}", mend="give a number from 0")


class ToolFeedback:
    """Corrections of the fingers' forces, of least norm for the moment asked for.

    In a transfer the moment counts amid the contacts instead of about the pivot.

    Attributes:
        gains: of the moment.
        pivot_in_tool: (3,) the pivot, about which the moment counts, tool frame [m].
    """

    def __init__(self, gains: ToolGains, pivot_in_tool: Array) -> None:
        """Feedback for the phases of one plan, about its tool's pivot."""
        self.gains, self.pivot_in_tool = gains, pivot_in_tool
        self._distributions: dict[int, Array] = {}

    def correction(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(m, 3) further force of each holding finger on the tool, **tool axes** [N].

        Args:
            task: of the phase.
            wanted: the plan now.
            measurement: the tool's pose and velocity in it.
        """
        turn, tool = measurement.tool_rotation, wanted.tool
        (_, xy, xz), (yx, _, yz), (zx, zy, _) = turn.T.dot(tool.rotation).tolist()
        # Half the antisymmetric part: the sine of the angle along the axis, in tool axes.
        angle = 0.5 * np.array((zy - yz, xz - zx, yx - xy))
        rate = (tool.angular_velocity - measurement.tool_angular_velocity).dot(turn)
        moment = self.gains.stiffness * angle + self.gains.damping * rate
        force = self._distribution(task).dot(moment).reshape(-1, 3)
        planned = (wanted.force_in_tool * task.normals_in_tool).sum(axis=1)
        size = np.sqrt((force * force).sum(axis=1)) + 1e-12
        allowed = np.minimum(1.0, self.gains.share * np.abs(planned) / size)
        return np.asarray(force * allowed[:, None])

    def _centre(self, task: PhaseTask) -> Array:
        """(3,) about which the moment counts: the pivot, or amid the fingers that carry the tool.

        Off the table nothing but the fingers takes up a force, so theirs must be a couple.
        """
        if task.reference.samples.kind == "transfer":
            return np.asarray(task.contacts_in_tool.mean(axis=0))
        return self.pivot_in_tool

    def _distribution(self, task: PhaseTask) -> Array:
        """(3 m, 3) forces per moment; a phase's contacts stay, so it is computed once."""
        index = task.reference.index
        if index not in self._distributions:
            levers = [pin.skew(lever) for lever in task.contacts_in_tool - self._centre(task)]
            moments = np.concatenate([np.zeros((3, 0)), *levers], axis=1)
            square = moments @ moments.T + _LEAST_LEVER**2 * np.eye(3)
            self._distributions[index] = moments.T @ np.linalg.inv(square)
        return self._distributions[index]
