"""Local coordinates of several robot frames on the moving tool, computed together.

The mathematics is that of :class:`pivotgait.kinematics.FrameCoordinates`; here all frames go
through one set of array operations, since a control cycle has no time for one set each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, hypot
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.control.tool_state import ToolState
from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import Hold, cross_matrix
from pivotgait.kinematics.local_coordinates import (
    SMALLEST_COS_PSI,
    rate_entries,
    rate_map_drift,
)

_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True, eq=False)
class FrameOnTool(FrozenArrays):
    """A robot frame, a frame C fixed in it, and the frame T on the tool that C is seen from.

    Attributes:
        frame_id: of the robot frame.
        frameRcontact: (3, 3) axes of C in the robot frame.
        toolRtarget: (3, 3) axes of T in the tool frame.
        centre: (3,) origin of T in the tool frame [m].
    """

    frame_id: int
    frameRcontact: Array
    toolRtarget: Array
    centre: Array

    @classmethod
    def of_hold(cls, hold: Hold) -> FrameOnTool:
        """A fingertip and its place on the tool."""
        return cls(hold.finger.tip_frame_id, hold.tipRcontact, hold.toolRtarget, hold.centre)


class FrameBundle:
    """xi = (theta, psi, phi, x, y, z) of K frames, with rates, Jacobians and drifts.

    d2xi/dt2 = jacobian qddot + drift, the tool's acceleration included. All are buffers that the
    next ``update`` overwrites.

    Attributes:
        value: (K, 6) xi [rad, m].
        rate: (K, 6) dxi/dt [rad/s, m/s], relative to the moving tool.
        jacobian: (K, 6, nv) derivative of xi with respect to q.
        drift: (K, 6) [rad/s^2, m/s^2].
        world_jacobian: (K, 6, nv) of the frames' origins in world axes, linear rows first.
    """

    def __init__(self, model: Any, data: Any, frames: Sequence[FrameOnTool]) -> None:
        """Coordinates of ``frames``, computed from ``data``, which the owner updates."""
        count = len(frames)
        self._model, self._data = model, data
        self._ids = [frame.frame_id for frame in frames]
        self._targets = np.stack([frame.toolRtarget for frame in frames])
        self._contacts = np.stack([frame.frameRcontact for frame in frames])
        centres = np.stack([frame.centre for frame in frames])
        self._centres_in_target = np.einsum("kji,kj->ki", self._targets, centres)
        placements = [data.oMf[index] for index in self._ids]
        # Views into data: they follow every update without a call.
        self._views = [(place.rotation, place.translation) for place in placements]
        self.value = np.zeros((count, 6))
        self.rate = np.zeros((count, 6))
        self.jacobian = np.zeros((count, 6, model.nv))
        self.drift = np.zeros((count, 6))
        self.world_jacobian = np.zeros((count, 6, model.nv))
        self._rotations = np.zeros((count, 3, 3))
        self._positions = np.zeros((count, 3))
        self._surge = np.zeros((count, 6))
        self._relative = np.zeros((count, 6))
        self._map = np.zeros((count, 6, 6))

    def update(self, v: Array, tool: ToolState) -> None:
        """Compute all after ``computeJointJacobians`` and ``forwardKinematics(q, v, 0)``.

        Args:
            v: (nv,) joint velocities.
            tool: on which T lies, with its motion.

        Raises:
            SingularCoordinatesError: where psi comes near +-90 degrees.
        """
        self._gather()
        targetRo = (tool.rotation @ self._targets).transpose(0, 2, 1)
        levers = self._positions - tool.position
        self.value[:, 3:] = (targetRo @ levers[:, :, None])[:, :, 0] - self._centres_in_target
        rates, slopes = self._angles((targetRo @ self._rotations @ self._contacts).tolist())
        self._map[:, :3, 3:] = rates @ targetRo
        self._map[:, 3:, :3] = targetRo
        np.matmul(self._map, self.world_jacobian, out=self.jacobian)
        self._move(v, tool, levers)
        for k, (tan_psi, sec_psi) in enumerate(slopes):
            self.drift[k, :3] += rate_map_drift(tan_psi, sec_psi, self.rate[k, :3].tolist())

    def _gather(self) -> None:
        model, data = self._model, self._data
        for k, index in enumerate(self._ids):
            pin.updateFramePlacement(model, data, index)
            self._rotations[k], self._positions[k] = self._views[k]
            self.world_jacobian[k] = pin.getFrameJacobian(model, data, index, _AXES)
            surge = pin.getFrameClassicalAcceleration(model, data, index, _AXES)
            self._surge[k] = surge.vector

    def _angles(self, rotations: list[Any]) -> tuple[Array, list[tuple[float, float]]]:
        """(K, 3, 3) rate maps E, and tangent and secant of psi of each frame."""
        entries, slopes = [], []
        for k, ((xx, xy, xz), (_, _, yz), (_, _, zz)) in enumerate(rotations):
            cos_psi = hypot(yz, zz)
            if cos_psi < SMALLEST_COS_PSI:
                name = self._model.frames[self._ids[k]].name
                raise SingularCoordinatesError(abs(atan2(xz, cos_psi)), where=name)
            self.value[k, :3] = atan2(-xy, xx), atan2(xz, cos_psi), atan2(-yz, zz)
            slope = xz / cos_psi, 1.0 / cos_psi
            entries.append(rate_entries(-yz / cos_psi, zz / cos_psi, *slope))
            slopes.append(slope)
        return np.array(entries), slopes

    def _move(self, v: Array, tool: ToolState, levers: Array) -> None:
        """Rates, and accelerations as the turning tool sees them: less its own and Coriolis'."""
        turning = cross_matrix(tool.angular_velocity)
        gradient = turning.dot(turning) + cross_matrix(tool.angular_acceleration)
        relative, surge = self._relative, self._surge
        twist = self.world_jacobian @ v
        relative[:, :3] = twist[:, :3] - (tool.linear_velocity + levers.dot(turning.T))
        relative[:, 3:] = twist[:, 3:] - tool.angular_velocity
        surge[:, :3] -= tool.linear_acceleration + levers.dot(gradient.T)
        surge[:, :3] -= 2.0 * relative[:, :3].dot(turning.T)
        surge[:, 3:] -= tool.angular_acceleration + twist[:, 3:].dot(turning.T)
        np.matmul(self._map, relative[:, :, None], out=self.rate[:, :, None])
        np.matmul(self._map, surge[:, :, None], out=self.drift[:, :, None])
