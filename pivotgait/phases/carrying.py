"""Joint motion that carries a held tool as if it and the hand were one rigid body."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import qr

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.phases.tracking import JointMotion, Untracked
from pivotgait.plans import ToolMotion

_AXES = pin.LOCAL_WORLD_ALIGNED
_ITERATIONS = 20
_TIGHT = 1e-12
"""Of the palm's pose [m, rad], far below what contacts may be off."""
_CONSISTENT = 1e-9
"""Of the palm's velocity and acceleration [m/s, rad/s, ...]."""
_POSE = 6


def carry(robot: Robot, time: Array, tool: ToolMotion, start: Array) -> JointMotion:
    """Move the palm with the tool; the fingers' joints stand still.

    So no fingertip rolls, slips or spins on the tool. Eq. (9) leaves the spin free, and a
    spinning tip would turn a tool that hangs between two of them.

    Args:
        robot: the arm-hand.
        time: (N,) from the phase's start [s].
        tool: N samples.
        start: (nv,) joint positions at the first of them.

    Raises:
        Untracked: the arm cannot move the palm with the tool.
    """
    arm = _Arm(robot, start)
    turn = tool.rotation.as_matrix()
    poses = [pin.SE3(each, np.array(at)) for each, at in zip(turn, tool.position, strict=True)]
    toolMpalm = poses[0].actInv(arm.palm(start))
    found = np.empty((3, len(time), robot.nv))
    q = np.array(start)
    for k, pose in enumerate(poses):
        target = pose.act(toolMpalm)
        reached = arm.follow(q, target)
        if reached is None:
            raise Untracked(k, q, float(time[k]))
        q = reached
        lever = target.translation - tool.position[k]
        rates = arm.rates(q, *_point_of_tool(tool, k, lever))
        if rates is None:
            raise Untracked(k, q, float(time[k]))
        found[:, k] = q, *rates
    return JointMotion(*found)


def _point_of_tool(tool: ToolMotion, k: int, lever: Array) -> tuple[Array, Array]:
    """(6,) velocity and acceleration [linear; angular] of the tool's point ``lever`` away."""
    omega, sigma = tool.angular_velocity[k], tool.angular_acceleration[k]
    turning = np.cross(omega, lever)
    surge = tool.linear_acceleration[k] + np.cross(sigma, lever) + np.cross(omega, turning)
    speed = tool.linear_velocity[k] + turning
    return np.concatenate((speed, omega)), np.concatenate((surge, sigma))


class _Arm:
    """The palm moved by those of the arm's joints, six at most, that do it best."""

    def __init__(self, robot: Robot, start: Array) -> None:
        self._robot, self._data = robot, robot.model.createData()
        jacobian = self._jacobian(start)[:, list(robot.palm_columns)]
        _, _, order = qr(jacobian, mode="economic", pivoting=True)
        self._columns: NDArray[np.intp] = np.array(robot.palm_columns)[order[:_POSE]]

    def palm(self, q: Array) -> pin.SE3:
        """The palm's pose."""
        model, data = self._robot.model, self._data
        pin.forwardKinematics(model, data, q)
        return pin.SE3(pin.updateFramePlacement(model, data, self._robot.palm_frame_id))

    def follow(self, q: Array, target: pin.SE3) -> Array | None:
        """(nv,) where the palm is at its target, by Newton's method; None if it cannot be."""
        q = np.array(q)
        for _ in range(_ITERATIONS):
            palm = self.palm(q)
            error = np.concatenate(
                (
                    target.translation - palm.translation,
                    palm.rotation @ pin.log3(palm.rotation.T @ target.rotation),
                )
            )
            if np.abs(error).max() < _TIGHT:
                return q
            q[self._columns] += np.linalg.lstsq(self._moves(q), error, rcond=None)[0]
        return None

    def rates(self, q: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array] | None:
        """(nv,) velocity and acceleration that move the palm so; None if there are none."""
        model, data, still = self._robot.model, self._data, np.zeros(self._robot.nv)
        v = self._solved(q, velocity)
        if v is None:
            return None
        pin.forwardKinematics(model, data, q, v, still)
        frame = self._robot.palm_frame_id
        drift = pin.getFrameClassicalAcceleration(model, data, frame, _AXES).vector
        a = self._solved(q, acceleration - drift)
        return None if a is None else (v, a)

    def _solved(self, q: Array, wanted: Array) -> Array | None:
        out, moves = np.zeros(self._robot.nv), self._moves(q)
        out[self._columns] = np.linalg.lstsq(moves, wanted, rcond=None)[0]
        missed = np.abs(moves @ out[self._columns] - wanted).max()
        return out if missed < _CONSISTENT else None

    def _moves(self, q: Array) -> Array:
        return np.asarray(self._jacobian(q)[:, self._columns])

    def _jacobian(self, q: Array) -> Array:
        model, data, frame = self._robot.model, self._data, self._robot.palm_frame_id
        return np.array(pin.computeFrameJacobian(model, data, q, frame, _AXES))
