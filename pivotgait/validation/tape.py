"""Collects the cycles of a run as they come."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.validation.series import RunSeries
from pivotgait.validation.simulator import TABLE_TOUCH, SimulatorState


class Tape:
    """Arrays made in advance, one row for each control cycle.

    Attributes:
        count: rows written.
    """

    def __init__(self, fingers: tuple[str, ...], joint_names: tuple[str, ...], cycles: int) -> None:
        """An empty tape of ``cycles`` rows."""
        self.count = 0
        self._fingers, self._joint_names = fingers, joint_names
        joints = len(joint_names)
        self._time = np.zeros(cycles)
        self._q, self._v, self._tau = (np.zeros((cycles, joints)) for _ in range(3))
        self._position, self._pivot_force = np.zeros((cycles, 3)), np.zeros((cycles, 3))
        self._rotation = np.zeros((cycles, 3, 3))
        self._force, self._reading = (np.zeros((cycles, len(fingers), 3)) for _ in range(2))
        self._touches: dict[str, list[float]] = {}

    def write(
        self, time: float, state: SimulatorState, torque: Array, reading: Mapping[str, Array]
    ) -> None:
        """Add a cycle: the state at its start and what was read and asked for then."""
        row = self.count
        self._time[row] = time
        self._q[row], self._v[row], self._tau[row] = state.q, state.v, torque
        self._position[row], self._rotation[row] = state.tool_position, state.tool_rotation
        self._pivot_force[row] = state.pivot_force
        for place, name in enumerate(self._fingers):
            self._force[row, place] = state.finger_force[name]
            self._reading[row, place] = reading[name]
        for pair in state.unwanted:
            self._touches.setdefault(pair, []).append(time)
        self.count += 1

    def series(self, *, diverged: str, pivot_in_tool: Array) -> RunSeries:
        """The cycles written so far."""
        rows = slice(0, self.count)
        touches = {name: np.array(times) for name, times in sorted(self._touches.items())}
        return RunSeries(
            fingers=self._fingers,
            joint_names=self._joint_names,
            time=self._time[rows],
            q=self._q[rows],
            v=self._v[rows],
            tau=self._tau[rows],
            tool_position=self._position[rows],
            tool_orientation=Rotation.from_matrix(self._rotation[rows]).as_quat(canonical=True),
            force=self._force[rows],
            reading=self._reading[rows],
            pivot_force=self._pivot_force[rows],
            touching_table=touches.pop(TABLE_TOUCH, np.zeros(0)),
            touches=touches,
            diverged=diverged,
            pivot_in_tool=pivot_in_tool,
        )
