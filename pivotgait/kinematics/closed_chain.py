"""The closed chain of arm, holding fingers and tool (Xue et al., eq. 9)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from pivotgait.frozen import Array, frozen
from pivotgait.kinematics.frame_coordinates import FrameCoordinates
from pivotgait.kinematics.hold import Hold
from pivotgait.kinematics.rigid_motion import RigidMotion
from pivotgait.models import Robot

ROWS_PER_HOLD = 5
"""S_i drops theta: rolling is held to zero, spin about the normal is free."""


class ClosedChain:
    """Equation (9) of every holding finger, stacked, with a tool that may move.

    A holding finger gives five rows in the order (psi, phi, x, y, z) of its local coordinates:
    two angles [rad] between tip and tool, then the tip centre's error in T axes [m]. With V
    the tool's velocity and A its acceleration,

        d residual/dt   = jacobian qdot - target_rate(V)
        d2 residual/dt2 = jacobian qddot - bias(qdot, V, A).

    ``residual`` and ``jacobian`` are buffers: the next ``update`` overwrites them, so copy what
    must last. A chain owns its ``pinocchio.Data``: use one chain per thread.

    Attributes:
        robot: the arm-hand.
        holds: the holding fingers, in the order of the rows.
        data: ``pinocchio.Data`` at the last ``update``, joint and fingertip placements included.
        fingers: the six local coordinates of each holding finger.
        residual: (5 m,) [rad, m].
        jacobian: (5 m, nv) derivative of ``residual`` with respect to q.
    """

    def __init__(self, robot: Robot, holds: Sequence[Hold]) -> None:
        """The chain through ``holds``, m of them; m may be 0."""
        self.robot, self.holds = robot, tuple(holds)
        self.data = robot.model.createData()
        self.fingers = tuple(
            FrameCoordinates.of_hold(robot.model, self.data, hold) for hold in self.holds
        )
        self.residual = np.zeros(ROWS_PER_HOLD * len(self.holds))
        self.jacobian = np.zeros((ROWS_PER_HOLD * len(self.holds), robot.nv))
        self._q = np.zeros(robot.nv)
        self._at_rest = np.zeros(robot.nv)
        self._is_angle = np.tile([True, True, False, False, False], len(self.holds))
        radii = np.repeat([hold.finger.tip_radius for hold in self.holds], ROWS_PER_HOLD)
        self._row_lengths = frozen(np.where(self._is_angle, radii, 1.0))
        self._rows = tuple(
            slice(start, start + ROWS_PER_HOLD)
            for start in range(0, len(self.residual), ROWS_PER_HOLD)
        )

    def __reduce__(self) -> tuple[type[ClosedChain], tuple[Robot, tuple[Hold, ...]]]:
        """Copies are built anew: a copied view would no longer follow the copied data."""
        return type(self), (self.robot, self.holds)

    @property
    def rows(self) -> int:
        """Number of rows, 5 m."""
        return len(self.residual)

    def row_lengths(self, angle_length: float | None = None) -> Array:
        """(5 m,) factors that turn every row into a length [m].

        Args:
            angle_length: length of one radian [m]; each finger's own tip radius if not given.
        """
        if angle_length is None:
            return self._row_lengths
        return np.where(self._is_angle, angle_length, 1.0)

    def update(self, q: Array, oRtool: Array, tool_position: Array) -> None:
        """Compute ``residual`` and ``jacobian``.

        Args:
            q: (nv,) configuration.
            oRtool: (3, 3) orientation of the tool, world <- tool.
            tool_position: (3,) origin of the tool frame (its centre of mass), world [m].

        Raises:
            SingularCoordinatesError: where a fingertip is turned by about 90 degrees from its
                hold.
        """
        self._q[:] = q
        pin.computeJointJacobians(self.robot.model, self.data, self._q)
        for finger, rows in zip(self.fingers, self._rows, strict=True):
            finger.refresh(oRtool, tool_position)
            self.residual[rows] = finger.value[1:]
            self.jacobian[rows] = finger.jacobian[1:]

    def target_rate(self, linear_velocity: Array, angular_velocity: Array) -> Array:
        """(5 m,) b of A qdot = b, under which the holds move with the tool (eq. 9).

        Args:
            linear_velocity: (3,) of the tool frame's origin, world [m/s].
            angular_velocity: (3,) of the tool, world [rad/s].
        """
        tool = RigidMotion(linear_velocity, angular_velocity)
        rate = np.empty(self.rows)
        for finger, rows in zip(self.fingers, self._rows, strict=True):
            rate[rows] = finger.target_rate(tool)[1:]
        return rate

    def bias(
        self,
        v: Array,
        linear_velocity: Array,
        angular_velocity: Array,
        linear_acceleration: Array,
        angular_acceleration: Array,
    ) -> Array:
        """(5 m,) right side of A qddot = bias, under which d2 residual/dt2 vanishes.

        Args:
            v: (nv,) joint velocities.
            linear_velocity: (3,) of the tool frame's origin, world [m/s].
            angular_velocity: (3,) of the tool, world [rad/s].
            linear_acceleration: (3,) of the tool frame's origin, world [m/s^2].
            angular_acceleration: (3,) of the tool, world [rad/s^2].
        """
        pin.forwardKinematics(self.robot.model, self.data, self._q, v, self._at_rest)
        tool = RigidMotion(
            linear_velocity, angular_velocity, linear_acceleration, angular_acceleration
        )
        bias = np.empty(self.rows)
        for finger, rows in zip(self.fingers, self._rows, strict=True):
            bias[rows] = -finger.drift(v, tool)[1:]
        return bias
