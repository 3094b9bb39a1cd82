"""What the controller reads: the simulator's state through imperfect sensors."""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.control.measurement import Measurement
from pivotgait.frozen import Array
from pivotgait.validation.perturbation import Perturbation
from pivotgait.validation.simulator import SimulatorState

_NOISE_STREAM = 1
"""Keeps the noise apart from the draw of the perturbation, which uses the seed alone."""


class Sensors:
    """Turns states into readings, one control cycle after another.

    Joints are read exactly. Fingertip forces are scaled, turned, noisy and late. The tool's pose
    is read with the error that the planner made, too: both see it by the same camera.

    Args:
        perturbation: of the trial.
        fingers: in the order of the noise.
        period_s: between readings [s].
    """

    def __init__(
        self, perturbation: Perturbation, fingers: tuple[str, ...], period_s: float
    ) -> None:
        sensing = perturbation.sensing
        self._fingers = fingers
        self._matrix = np.stack([sensing.gain[name] * sensing.turn[name] for name in fingers])
        self._noise = sensing.noise
        self._rng = np.random.default_rng([perturbation.seed, _NOISE_STREAM])
        self._late: deque[Array] = deque(maxlen=round(sensing.delay_s / period_s) + 1)
        self._offset = np.array([*perturbation.offset[:2], 0.0])
        turn = Rotation.from_rotvec([0.0, 0.0, -perturbation.offset[2]])
        self._back: Array = turn.as_matrix()

    def read(self, time: float, state: SimulatorState) -> Measurement:
        """The reading of a state, ``time`` [s] after the plan's start."""
        forces = self._forces(state)
        return Measurement(
            time=time,
            q=state.q,
            v=state.v,
            force=dict(zip(self._fingers, forces, strict=True)),
            tool_position=state.tool_position - self._offset,
            tool_rotation=self._back @ state.tool_rotation,
            tool_linear_velocity=state.tool_linear_velocity,
            tool_angular_velocity=state.tool_angular_velocity,
        )

    def _forces(self, state: SimulatorState) -> Array:
        true = np.array([state.finger_force[name] for name in self._fingers])
        reading = np.matmul(self._matrix, true[:, :, None])[:, :, 0]
        if self._noise > 0.0:
            reading = reading + self._noise * self._rng.standard_normal(reading.shape)
        self._late.append(reading)
        return self._late[0]
