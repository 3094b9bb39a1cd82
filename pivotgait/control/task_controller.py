"""What the torque laws have in common: task rows, planned feed-forward, resolution."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pinocchio as pin

from pivotgait.control.gains import HybridGains
from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, Reference
from pivotgait.control.resolution import Resolution
from pivotgait.control.tool_feedback import ToolFeedback, ToolGains
from pivotgait.frozen import Array


class TaskController(ABC):
    """Torques by eqs (11)-(17); a law says only how z is resolved.

    Fingers are controlled relative to the **planned** tool. The feed-forward J^T f of eq. (17)
    uses the **planned** forces, turned with the **measured** tool: measured forces there drift to
    the edge of their cones, and forces that keep their direction while the tool turns are a couple
    that turns it on, as of a column under load.

    Attributes:
        reference: the plan.
        gains: of eqs (12) and (14).
        resolution: of joint accelerations.
        tasks: of each phase.
    """

    def __init__(
        self,
        reference: Reference,
        gains: HybridGains | None = None,
        *,
        tool_gains: ToolGains | None = None,
    ) -> None:
        """A controller of one run after another; it owns its ``pinocchio.Data``.

        Args:
            reference: the plan.
            gains: of the fingers; the default ones if not given.
            tool_gains: of the forces that turn the tool back; none without.
        """
        self.reference = reference
        self.gains = HybridGains() if gains is None else gains
        self._feedback = (
            None
            if tool_gains is None
            else ToolFeedback(tool_gains, reference.plan.tool.pivot_in_tool)
        )
        robot = reference.robot
        self._model, self._data = robot.model, robot.model.createData()
        self._rest = np.zeros(robot.nv)
        # By the planned velocity: cancelling it by the measured one would feed errors back.
        self._joint_damping = np.array(robot.model.damping)
        self.tasks = tuple(PhaseTask(robot, self._data, phase) for phase in reference.phases)
        self.resolution = Resolution(robot, robot.model.createData())

    def reset(self) -> None:
        """Start anew, before the first cycle of a run."""
        self.resolution.reset()

    def torque(self, measurement: Measurement) -> Array:
        """(n,) joint torques [N m] or [N] that follow the plan of the measurement's time."""
        return self.follow(self.reference.at(measurement.time), measurement)

    def follow(self, wanted: Instant, measurement: Measurement) -> Array:
        """(n,) tau = M qddot + N + J^T f with qddot = H^-1 (s_res - dH/dt qdot) (eqs 15-17).

        Args:
            wanted: what to follow now, of the reference's phases; at its own pace.
            measurement: now.
        """
        task = self.tasks[wanted.phase]
        if self._feedback is not None:
            more = self._feedback.correction(task, wanted, measurement)
            wanted = wanted._replace(force_in_tool=wanted.force_in_tool + more)
        q, v = measurement.q, measurement.v
        pin.computeJointJacobians(self._model, self._data, q)
        pin.forwardKinematics(self._model, self._data, q, v, self._rest)
        task.update(q, v, wanted)
        gains = self.gains
        resolved = task.feed_forward + gains.velocity * task.rate_error
        resolved += gains.position * task.error
        if len(task.z_rows):
            resolved[task.z_rows] = self.resolved_normal(task, wanted, measurement)
        posture = wanted.a + gains.velocity * (wanted.v - v) + gains.position * (wanted.q - q)
        load = (
            contact_load(task, wanted, measurement.tool_rotation) + self._joint_damping * wanted.v
        )
        return self.resolution.torque(task, resolved, posture, measurement, load)

    @abstractmethod
    def resolved_normal(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(m,) z of the holding fingers, resolved, less the part of d2z/dt2 without qddot."""


def contact_load(task: PhaseTask, wanted: Instant, turn: Array) -> Array:
    """(n,) J^T f of the planned forces, J of the tips' surfaces at the contacts (eq. 17).

    Moments that soft fingertips are planned to bear about their normals are part of f.

    Args:
        task: updated.
        wanted: the plan now.
        turn: (3, 3) world <- tool, with which the forces turn.
    """
    moment = (task.lever_crosses @ wanted.force_in_tool[:, :, None])[:, :, 0]
    if wanted.moment is not None:
        moment += wanted.moment[:, None] * task.normals_in_tool
    wrench = np.concatenate((wanted.force_in_tool.dot(turn.T), moment.dot(turn.T)), axis=1)
    jacobian = task.frames.world_jacobian[: len(wrench)]
    return np.asarray(wrench.ravel().dot(jacobian.reshape(-1, jacobian.shape[2])))


def planned_normal(task: PhaseTask, wanted: Instant) -> Array:
    """(m,) planned normal forces f_nd [N]."""
    return np.asarray((wanted.force_in_tool * task.normals_in_tool).sum(axis=1))


def measured_normal(task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
    """(m,) measured forces along the planned normals f_n [N]."""
    forces = [measurement.force.get(name, _NONE) for name in task.finger_names]
    in_tool = np.array(forces).dot(wanted.tool.rotation)
    return np.asarray((in_tool * task.normals_in_tool).sum(axis=1))


_NONE = np.zeros(3)
