"""Task coordinates of one phase (Xue et al., eqs 11, 13): rows, their rates and references."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.control.curves import Curves, quintic_spline
from pivotgait.control.frame_bundle import FrameBundle, FrameOnTool
from pivotgait.control.reference import Instant, PhaseReference
from pivotgait.frozen import Array
from pivotgait.kinematics import PalmRows, TaskJacobian, choose_palm_rows, palm_axes
from pivotgait.kinematics.closed_chain import ROWS_PER_HOLD
from pivotgait.models import Robot

CHOICE_SAMPLES = 9
"""Samples of a phase at which the palm's rows are judged."""


class PhaseTask:
    """s of one phase: five rows of each holding finger, idle joints, and the palm's rest.

    The rows are those of :class:`pivotgait.kinematics.TaskJacobian`: (psi, phi, x, y, z) of each
    holding finger relative to the **planned** tool, the joints of every other finger, a
    relocating one among them, and those coordinates of the palm that keep H farthest from
    singular over the phase.

    Attributes:
        reference: the phase.
        palm_rows: chosen.
        smallest_singular_value: of the scaled H over the planned phase [m].
        row_scale: (n,) factors that turn the rows of H into lengths.
        column_scale: (n,) factors of its columns.
        joint_columns: joints that are controlled by themselves.
        z_rows: rows of the holding fingers' z.
        finger_names: of the m holding fingers.
        normals_in_tool: (m, 3) inward normals, tool frame.
        lever_crosses: (m, 3, 3) [l]x of the levers l from the tips' centres to their contacts,
            tool frame [m].
        contacts_in_tool: (m, 3) contact points, tool frame [m].
        frames: the m holding fingers, then the palm.
        matrix: (n, n) H at the last ``update``.
        error: (n,) s_d - s, with z_d = 0: the fingertip just touches the planned tool.
        rate_error: (n,) its time derivative.
        feed_forward: (n,) d2s_d/dt2 less the part of d2s/dt2 that needs no qddot, the tool's
            acceleration included (eqs 15-16): H qddot that keeps the errors' rates.
    """

    def __init__(self, robot: Robot, data: pin.Data, reference: PhaseReference) -> None:
        """The task of a phase, computed from ``data``, which the owner updates."""
        self.reference = reference
        holds, samples, motion = reference.holds, reference.samples, reference.motion
        tool = samples.tool
        turn = tool.rotation.as_matrix()
        middle = len(turn) // 2
        toolRpalm = palm_axes(robot, motion.q[middle], turn[middle])
        task = TaskJacobian(robot, holds, palm_target=toolRpalm)
        chosen = np.linspace(0, len(turn) - 1, CHOICE_SAMPLES).round().astype(int)
        choice = choose_palm_rows(task, motion.q[chosen], turn[chosen], tool.position[chosen])
        self.palm_rows: PalmRows = choice.rows
        self.smallest_singular_value = choice.smallest_singular_value
        palm = FrameOnTool(robot.palm_frame_id, np.eye(3), toolRpalm, np.zeros(3))
        on_tool = [*(FrameOnTool.of_hold(hold) for hold in holds), palm]
        self.frames = FrameBundle(robot.model, data, on_tool)
        self._palm_curves = _palm_curves(robot, reference, palm)
        self.row_scale = task.row_scale(choice.rows)
        self.column_scale = task.column_scale
        self._lay_out(robot, task)

    def _lay_out(self, robot: Robot, task: TaskJacobian) -> None:
        fingers = len(self.reference.holds)
        held = ROWS_PER_HOLD * fingers
        by_joint = [*task.idle_columns, *self.palm_rows.joints]
        palm = list(self.palm_rows.coordinates)
        self._fingers, self._held = fingers, slice(0, held)
        idle_end = held + len(task.idle_columns)
        self._palm = slice(idle_end, idle_end + len(palm))
        self._coordinates = np.array(palm, dtype=int)
        rows = [*range(held, idle_end), *range(self._palm.stop, robot.nv)]
        self._joint_rows = np.array(rows, dtype=int)
        self.joint_columns = np.array(by_joint, dtype=int)
        holds = self.reference.holds
        self.finger_names = tuple(hold.finger.name for hold in holds)
        self.normals_in_tool = np.array([hold.normal for hold in holds]).reshape(-1, 3)
        radii = np.array([[hold.finger.tip_radius] for hold in holds]).reshape(-1, 1)
        levers = radii * self.normals_in_tool
        self.lever_crosses = np.array([pin.skew(lever) for lever in levers]).reshape(-1, 3, 3)
        centres = np.array([hold.centre for hold in holds]).reshape(-1, 3)
        self.contacts_in_tool = centres + levers
        self.z_rows = np.arange(ROWS_PER_HOLD - 1, held, ROWS_PER_HOLD)
        self.matrix = np.zeros((robot.nv, robot.nv))
        self.matrix[self._joint_rows, self.joint_columns] = 1.0
        self.error, self.rate_error, self.feed_forward = np.zeros((3, robot.nv))
        self._errors = (self.error, self.rate_error, self.feed_forward)

    def update(self, q: Array, v: Array, wanted: Instant) -> None:
        """Compute the rows after ``computeJointJacobians`` and ``forwardKinematics(q, v, 0)``.

        Args:
            q: (n,) joint positions.
            v: (n,) joint velocities.
            wanted: the plan now.

        Raises:
            SingularCoordinatesError: for a tip or the palm turned 90 degrees from its target.
        """
        frames, m, held, palm = self.frames, self._fingers, self._held, self._palm
        frames.update(v, wanted.tool)
        self.matrix[held] = frames.jacobian[:m, 1:].reshape(-1, len(q))
        self.matrix[palm] = frames.jacobian[m, self._coordinates]
        palm_wanted = self._palm_curves(wanted.time_in_phase)[:, self._coordinates]
        if wanted.pace is not None:
            palm_wanted = np.array(wanted.pace.rates(*palm_wanted))
        found = (frames.value, frames.rate, frames.drift)
        columns, rows = self.joint_columns, self._joint_rows
        joints = (wanted.q - q, wanted.v - v, wanted.a)
        for k, error in enumerate(self._errors):
            error[held] = found[k][:m, 1:].ravel()
            error[held] *= -1.0
            error[palm] = palm_wanted[k] - found[k][m, self._coordinates]
            error[rows] = joints[k][columns]


def _palm_curves(robot: Robot, reference: PhaseReference, palm: FrameOnTool) -> Curves:
    """The planned xi of the palm as curves in time."""
    model, data = robot.model, robot.model.createData()
    frame = FrameBundle(model, data, [palm])
    samples = reference.samples
    found = np.empty((3, len(samples.time), 6))
    for k, time in enumerate(samples.time - samples.time[0]):
        wanted = reference.at(float(time))
        pin.computeJointJacobians(model, data, wanted.q)
        pin.forwardKinematics(model, data, wanted.q, wanted.v, wanted.a)
        frame.update(wanted.v, wanted.tool)
        # With the joints' accelerations in data, the drift is all of d2xi/dt2.
        found[:, k] = frame.value[0], frame.rate[0], frame.drift[0]
    return Curves(samples.time, quintic_spline(samples.time, *found))
