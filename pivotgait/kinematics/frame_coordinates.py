"""Local coordinates of one robot frame relative to a frame on the moving tool (eq. 10)."""

from __future__ import annotations

from math import atan2, hypot
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array
from pivotgait.kinematics.hold import Hold
from pivotgait.kinematics.local_coordinates import (
    SMALLEST_COS_PSI,
    rate_entries,
    rate_map_drift,
)
from pivotgait.kinematics.rigid_motion import RigidMotion

WORLD_AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class FrameCoordinates:
    """xi = (theta, psi, phi, x, y, z) of a frame C, fixed in a robot frame, relative to T.

    T is fixed in the tool; x, y, z are the robot frame's origin in T axes, relative to T's
    origin. With V the tool's velocity,

        dxi/dt = jacobian(q) qdot - target_rate(V)                        (Xue et al., eq. 10)

    where the rate of T is not zero while the tool moves. The object computes from the
    ``pinocchio.Data`` it is given, which it shares with its owner and with no other thread.
    ``value`` and ``jacobian`` are buffers that the next ``refresh`` overwrites.

    Attributes:
        value: (6,) xi [rad, m].
        jacobian: (6, nv) dxi/dq at a resting tool.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        frame_id: int,
        *,
        frameRcontact: Array,
        toolRtarget: Array,
        centre: Array,
    ) -> None:
        """Coordinates of frame ``frame_id``.

        Args:
            model: ``pinocchio.Model``.
            data: its ``pinocchio.Data``, updated by the owner.
            frame_id: of the robot frame.
            frameRcontact: (3, 3) axes of C in the robot frame.
            toolRtarget: (3, 3) axes of T in the tool frame.
            centre: (3,) origin of T in the tool frame [m].
        """
        self._model, self._data, self._frame_id = model, data, frame_id
        self._frameRcontact, self._toolRtarget = frameRcontact, toolRtarget
        self._centre_in_target = np.asarray(toolRtarget.T @ centre)
        # Views into data: they follow every update without a call.
        self._placement = data.oMf[frame_id]
        self._oRframe = self._placement.rotation
        self._position = self._placement.translation
        self.value = np.zeros(6)
        self.jacobian = np.zeros((6, model.nv))
        self._oRtarget = np.eye(3)
        self._lever = np.zeros(3)
        self._twist = np.zeros(6)
        self._map = np.zeros((6, 6))
        self._world_jacobian = np.zeros((6, model.nv))
        self._trigonometry = (0.0, 1.0, 0.0, 1.0)

    @classmethod
    def of_hold(cls, model: Any, data: Any, hold: Hold) -> FrameCoordinates:
        """Coordinates of a fingertip relative to its hold."""
        return cls(
            model,
            data,
            hold.finger.tip_frame_id,
            frameRcontact=hold.tipRcontact,
            toolRtarget=hold.toolRtarget,
            centre=hold.centre,
        )

    def refresh(self, oRtool: Array, tool_position: Array) -> None:
        """Compute ``value`` and ``jacobian`` after ``pin.computeJointJacobians(model, data, q)``.

        Args:
            oRtool: (3, 3) orientation of the tool, world <- tool.
            tool_position: (3,) origin of the tool frame, world [m].

        Raises:
            SingularCoordinatesError: where psi comes near +-90 degrees.
        """
        pin.updateFramePlacement(self._model, self._data, self._frame_id)
        np.dot(oRtool, self._toolRtarget, out=self._oRtarget)
        targetRo = self._oRtarget.T
        np.subtract(self._position, tool_position, out=self._lever)
        self._angles(targetRo.dot(self._oRframe).dot(self._frameRcontact).tolist())
        self.value[3:] = targetRo.dot(self._lever) - self._centre_in_target
        self._map[:3, 3:] = np.array(rate_entries(*self._trigonometry)).dot(targetRo)
        self._map[3:, :3] = targetRo
        self._world_jacobian = pin.getFrameJacobian(
            self._model, self._data, self._frame_id, WORLD_AXES
        )
        np.dot(self._map, self._world_jacobian, out=self.jacobian)

    def _angles(self, rotation: list[list[float]]) -> None:
        """Angles of T <- C as floats: an order faster than arrays of one element."""
        (xx, xy, xz), (_, _, yz), (_, _, zz) = rotation
        cos_psi = hypot(yz, zz)
        psi = atan2(xz, cos_psi)
        if cos_psi < SMALLEST_COS_PSI:
            raise SingularCoordinatesError(abs(psi), where=self._model.frames[self._frame_id].name)
        self.value[:3] = atan2(-xy, xx), psi, atan2(-yz, zz)
        self._trigonometry = (-yz / cos_psi, zz / cos_psi, xz / cos_psi, 1.0 / cos_psi)

    def target_rate(self, tool: RigidMotion) -> Array:
        """(6,) what the tool's motion takes from dxi/dt: J qdot equal to it keeps xi constant."""
        self._twist[:3] = tool.velocity_at(self._lever)
        self._twist[3:] = tool.angular_velocity
        rate: Array = self._map.dot(self._twist)
        return rate

    def drift(self, v: Array, tool: RigidMotion) -> Array:
        """(6,) d2xi/dt2 at zero joint acceleration, so that d2xi/dt2 = J qddot + drift.

        Call after ``refresh`` and ``pin.forwardKinematics(model, data, q, v, 0)``.

        Args:
            v: (nv,) joint velocities.
            tool: motion of the tool, accelerations included.
        """
        twist = self._world_jacobian.dot(v)
        acceleration = pin.getFrameClassicalAcceleration(
            self._model, self._data, self._frame_id, WORLD_AXES
        ).vector
        relative = twist[:3] - tool.velocity_at(self._lever)
        # What the turning tool sees: less its own acceleration there, less Coriolis'.
        acceleration[:3] -= tool.acceleration_at(self._lever) + 2.0 * tool.turning.dot(relative)
        acceleration[3:] -= tool.angular_acceleration + tool.turning.dot(twist[3:])
        drift: Array = self._map.dot(acceleration)
        rates = self._map[:3, 3:].dot(twist[3:] - tool.angular_velocity).tolist()
        drift[:3] += rate_map_drift(self._trigonometry[2], self._trigonometry[3], rates)
        return drift
