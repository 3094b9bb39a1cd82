"""The servo of a position-commanded robot: joint springs of stated stiffness."""

from __future__ import annotations

from math import isfinite

import numpy as np
import pinocchio as pin

from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.models import Robot

DAMPING_RATIO = 1.0
TOUCHING = 0.05
"""Normal force above which a fingertip counts as held by its contact [N]."""
_SLACK = 1e-6
"""Of the contact rows: their compliance [1/kg], which keeps the equations regular."""


class Servo:
    """tau = N + K (q_c - q) + D (v_c - v) with a diagonal K, stable at any stiffness.

    Each joint's spring is as stiff as a tip is to be that hangs on this joint alone: K_i = k l_i^2
    with l_i the joint's longest lever to a fingertip. D_i is critical for the joint's own
    inertia. Links are so light that the springs of 20 kN/m would swing at a control cycle's
    frequency; position and velocity are therefore those at the **end** of the cycle, as the
    joints will accelerate (Tan, Liu and Turk, "Stable Proportional-Derivative Controllers",
    2011) with the fingertips that touch the tool held by it. At rest the stiffness is K.

    Attributes:
        stiffness: (n,) K [N m/rad] or [N/m].
        damping: (n,) D [N m s/rad] or [N s/m].
    """

    def __init__(self, robot: Robot, q: Array, tip_stiffness: float, period: float) -> None:
        """A servo with levers and inertias at a posture.

        Args:
            robot: the arm-hand.
            q: (n,) posture.
            tip_stiffness: k [N/m].
            period: of the control cycle [s].

        Raises:
            InputError: for a stiffness or a period that is no positive number.
        """
        for name, value in (("tip stiffness", tip_stiffness), ("period", period)):
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"{name} {value}", where="servo", mend="give a positive number")
        self._model, self._data, self._period = robot.model, robot.model.createData(), period
        self.stiffness = tip_stiffness * _levers(robot, q) ** 2
        inertia = np.diag(pin.crba(robot.model, self._data, q))
        self.damping = 2.0 * DAMPING_RATIO * np.sqrt(self.stiffness * inertia)
        self._held = self.stiffness * period**2 + self.damping * period

    def torque(
        self, q: Array, v: Array, q_wanted: Array, v_wanted: Array, contacts: Array
    ) -> Array:
        """(n,) torques.

        Args:
            q: (n,) joint positions.
            v: (n,) velocities.
            q_wanted: (n,) commanded positions q_c.
            v_wanted: (n,) commanded velocities v_c.
            contacts: (c, n) Jacobians along the normals of the fingertips that touch the tool.
        """
        n = len(q)
        spring = self.stiffness * (q_wanted - q - self._period * v)
        drive = spring + self.damping * (v_wanted - v)
        inertia = np.array(pin.crba(self._model, self._data, q))
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        size = n + len(contacts)
        system = np.zeros((size, size))
        system[:n, :n] = inertia + np.diag(self._held)
        system[:n, n:], system[n:, :n] = contacts.T, contacts
        system[range(n, size), range(n, size)] = -_SLACK
        right = np.concatenate((drive, np.zeros(len(contacts))))
        ahead = np.linalg.solve(system, right)[:n]
        bias = np.asarray(pin.nonLinearEffects(self._model, self._data, q, v))
        return np.asarray(bias + drive - self._held * ahead)


def touching_rows(task: PhaseTask, wanted: Instant, normal_forces: Array) -> Array:
    """(c, n) Jacobians along the normals of the tips that press with more than ``TOUCHING``.

    Args:
        task: updated.
        wanted: the plan now.
        normal_forces: (m,) measured [N].
    """
    jacobian = task.frames.world_jacobian[: len(normal_forces)]
    normals = task.normals_in_tool.dot(wanted.tool.rotation.T)
    along = (normals[:, None, :] @ jacobian[:, :3])[:, 0]
    return np.asarray(along[normal_forces > TOUCHING])


def _levers(robot: Robot, q: Array) -> Array:
    """(n,) longest lever of each joint to a fingertip [m]; one for a joint that slides."""
    data = robot.model.createData()
    pin.computeJointJacobians(robot.model, data, q)
    levers = np.zeros(robot.nv)
    for finger in robot.fingers.values():
        pin.updateFramePlacement(robot.model, data, finger.tip_frame_id)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        full = pin.getFrameJacobian(robot.model, data, finger.tip_frame_id, axes)
        levers = np.maximum(levers, np.sqrt((full[:3] ** 2).sum(axis=0)))
    if np.any(levers <= 0.0):
        raise InputError(
            "a joint moves no fingertip", where=robot.name, mend="fix it in the robot's URDF"
        )
    return levers
