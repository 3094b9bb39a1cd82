"""Collects the cycles of a run as they come."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.validation.series import RunSeries
from pivotgait.validation.simulator import TABLE_TOUCH, SimulatorState


class Tape:
    """One row for each control cycle. Keeps the arrays it is given: their owners make new ones."""

    def __init__(self, fingers: tuple[str, ...], joint_names: tuple[str, ...]) -> None:
        """An empty tape."""
        self._fingers, self._joint_names = fingers, joint_names
        self._time: list[float] = []
        self._states: list[SimulatorState] = []
        self._tau: list[Array] = []
        self._readings: list[Mapping[str, Array]] = []
        self._plan_time: list[float] = []

    @property
    def count(self) -> int:
        """Rows written."""
        return len(self._time)

    def write(
        self,
        time: float,
        state: SimulatorState,
        torque: Array,
        reading: Mapping[str, Array],
        plan_time: float | None = None,
    ) -> None:
        """Add a cycle: the state at its start and what was read and asked for then.

        Of a controller with a clock of its own, each cycle has the plan's time, too.
        """
        self._time.append(time)
        self._states.append(state)
        self._tau.append(torque)
        self._readings.append(reading)
        if plan_time is not None:
            self._plan_time.append(plan_time)

    def series(self, *, diverged: str, pivot_in_tool: Array) -> RunSeries:
        """The cycles written so far."""
        states, joints = self._states, len(self._joint_names)
        rotation = _rows([each.tool_rotation for each in states], (3, 3))
        touches = self._touches()
        return RunSeries(
            fingers=self._fingers,
            joint_names=self._joint_names,
            time=np.array(self._time),
            q=_rows([each.q for each in states], (joints,)),
            v=_rows([each.v for each in states], (joints,)),
            tau=_rows(self._tau, (joints,)),
            tool_position=_rows([each.tool_position for each in states], (3,)),
            tool_orientation=Rotation.from_matrix(rotation).as_quat(canonical=True),
            force=self._by_finger([each.finger_force for each in states]),
            reading=self._by_finger(self._readings),
            pivot_force=_rows([each.pivot_force for each in states], (3,)),
            touching_table=touches.pop(TABLE_TOUCH, np.zeros(0)),
            touches=touches,
            diverged=diverged,
            pivot_in_tool=pivot_in_tool,
            plan_time=np.array(self._plan_time) if self._plan_time else None,
        )

    def _by_finger(self, forces: Sequence[Mapping[str, Array]]) -> Array:
        """(N, fingers, 3)."""
        rows = [[each[name] for name in self._fingers] for each in forces]
        return _rows(rows, (len(self._fingers), 3))

    def _touches(self) -> dict[str, Array]:
        """Times [s] by the names of what touches, sorted."""
        found: dict[str, list[float]] = {}
        for time, state in zip(self._time, self._states, strict=True):
            for pair in state.unwanted:
                found.setdefault(pair, []).append(time)
        return {pair: np.array(found[pair]) for pair in sorted(found)}


def _rows(values: Sequence[Any], shape: tuple[int, ...]) -> Array:
    """(N, *shape), also of none."""
    return np.array(values, dtype=float).reshape(-1, *shape)
