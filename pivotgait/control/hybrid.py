"""Hybrid position/impedance control of arm, fingers and tool (Xue et al., Section VI)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dgetrf, dgetrs

from pivotgait.control.gains import HybridGains
from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, Reference
from pivotgait.frozen import Array


class HybridController:
    """Torques by eqs (11)-(17): angles and tangents by position (12), normals by impedance (14).

    Fingers are controlled relative to the **planned** tool; the feed-forward J^T f uses the
    **planned** forces turned with the planned tool; of the measured forces only the normal part
    is used, in (14). So nothing depends on the measured pose of the tool.

    Attributes:
        reference: the plan.
        gains: of eqs (12) and (14).
    """

    def __init__(self, reference: Reference, gains: HybridGains | None = None) -> None:
        """A controller of one run after another; it owns its ``pinocchio.Data``."""
        self.reference = reference
        self.gains = HybridGains() if gains is None else gains
        robot = reference.robot
        self._model, self._data = robot.model, robot.model.createData()
        self._rest = np.zeros(robot.nv)
        self._tasks = [PhaseTask(robot, self._data, phase) for phase in reference.phases]

    def reset(self) -> None:
        """Nothing to forget: the law has no memory."""

    def torque(self, measurement: Measurement) -> Array:
        """(n,) tau = M qddot + N + J^T f with qddot = H^-1 (s_res - ...) (eqs 15-17)."""
        wanted = self.reference.at(measurement.time)
        task = self._tasks[wanted.phase]
        q, v = measurement.q, measurement.v
        pin.computeJointJacobians(self._model, self._data, q)
        pin.forwardKinematics(self._model, self._data, q, v, self._rest)
        task.update(q, v, wanted)
        load = self._load(task, wanted)
        acceleration = self._resolved(task, wanted, measurement)
        factors, pivots, _ = dgetrf(task.matrix)
        qddot, _ = dgetrs(factors, pivots, acceleration)
        return np.asarray(pin.rnea(self._model, self._data, q, v, qddot) + load)

    def _resolved(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(n,) H qddot that eqs (12) and (14) ask for."""
        gains = self.gains
        resolved: Array = task.feed_forward + gains.velocity * task.rate_error
        resolved += gains.position * task.error
        rows = task.z_rows
        if len(rows):
            pressing = self._pressing(task, wanted, measurement)
            resolved[rows] = task.feed_forward[rows] + pressing / gains.impedance_mass
        return resolved

    def _pressing(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(m,) right side of eq. (14) [N]."""
        gains, rows = self.gains, task.z_rows
        normals = task.normals_in_tool
        planned = (wanted.force_in_tool * normals).sum(axis=1)
        forces = [measurement.force.get(name, _NONE) for name in task.finger_names]
        measured = (np.array(forces).dot(wanted.tool.rotation) * normals).sum(axis=1)
        error = task.error[rows] + planned / gains.contact_stiffness
        pressing: Array = planned - measured + gains.impedance_damping * task.rate_error[rows]
        return pressing + gains.impedance_stiffness * error

    def _load(self, task: PhaseTask, wanted: Instant) -> Array:
        """(n,) J^T f of the planned forces, J at the contacts (eq. 17)."""
        turn = wanted.tool.rotation
        force = wanted.force_in_tool.dot(turn.T)
        lever = task.levers_in_tool.dot(turn.T)
        wrench = np.concatenate((force, np.cross(lever, force)), axis=1)
        jacobian = task.frames.world_jacobian[: len(force)]
        return jacobian.reshape(-1, jacobian.shape[2]).T.dot(wrench.ravel())


_NONE = np.zeros(3)
