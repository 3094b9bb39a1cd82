"""A stiff position servo on the planned joint motion: a baseline (the paper's Fig. 8)."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Reference
from pivotgait.control.servo import Servo, touching_rows
from pivotgait.control.task_controller import contact_load, measured_normal
from pivotgait.frozen import Array

TIP_STIFFNESS = 20e3
"""Default stiffness at a fingertip [N/m]."""


class PositionController:
    """Joints follow the plan, displaced by what the planned forces bend the servo's springs.

    q_c = q_d + K^-1 J^T f, so that a perfect model presses as planned. Forces are not controlled;
    their readings only tell the servo which fingertips touch.

    Attributes:
        reference: the plan.
        servo: of the robot.
    """

    def __init__(
        self,
        reference: Reference,
        *,
        tip_stiffness: float = TIP_STIFFNESS,
        period: float = 1e-3,
    ) -> None:
        """A controller of one run after another.

        Args:
            reference: the plan.
            tip_stiffness: of the servo at a fingertip [N/m].
            period: of the control cycle [s].

        Raises:
            InputError: for a stiffness or a period that is no positive number.
        """
        self.reference = reference
        robot = reference.robot
        self.servo = Servo(robot, reference.at(0.0).q, tip_stiffness, period)
        self._model, self._data = robot.model, robot.model.createData()
        self._rest = np.zeros(robot.nv)
        self._tasks = tuple(PhaseTask(robot, self._data, phase) for phase in reference.phases)

    def reset(self) -> None:
        """Nothing to forget."""

    def torque(self, measurement: Measurement) -> Array:
        """(n,) torques of the servo."""
        wanted = self.reference.at(measurement.time)
        task, q, v = self._tasks[wanted.phase], measurement.q, measurement.v
        pin.computeJointJacobians(self._model, self._data, q)
        pin.forwardKinematics(self._model, self._data, q, v, self._rest)
        task.update(q, v, wanted)
        rows = touching_rows(task, wanted, measured_normal(task, wanted, measurement))
        bent = contact_load(task, wanted, wanted.tool.rotation) / self.servo.stiffness
        return self.servo.torque(q, v, wanted.q + bent, wanted.v, rows)
