"""Admittance control of a position-commanded robot (Xue et al., Section VII)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite

import numpy as np
import pinocchio as pin

from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, Reference
from pivotgait.control.servo import Servo, touching_rows
from pivotgait.control.task_controller import contact_load, measured_normal, planned_normal
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.kinematics import ClosedChain
from pivotgait.kinematics.closed_chain import ROWS_PER_HOLD

LARGEST_OFFSET = 3e-3
"""Of a fingertip along its normal [m]."""
INVERSE_DAMPING = 1e-3
"""Of the inverse Jacobian, in lengths [m]."""
ITERATIONS = 2
"""Steps of the inverse Jacobian in each cycle, from the last cycle's answer."""


@dataclass(frozen=True)
class AdmittanceGains:
    """Gains of the admittance law and of the servo below it.

    Attributes:
        admittance: K_a [N/m]: a force error of K_a newtons moves the fingertip by a metre.
        position: k_p [N/m], weight of the position error against the force error.
        integral: 1/(K_a T) [m/(N s)]: speed of the fingertip under a lasting force error.
        tip_stiffness: of the servo at a fingertip [N/m].
    """

    admittance: float = 1e4
    position: float = 100.0
    integral: float = 2e-3
    tip_stiffness: float = 2e3

    def __post_init__(self) -> None:
        """Refuse gains that are negative or no numbers."""
        for entry in fields(self):
            value = getattr(self, entry.name)
            least_is_zero = entry.name in ("position", "integral")
            if not (isfinite(value) and (value > 0.0 or (least_is_zero and value == 0.0))):
                raise InputError(f"gain {entry.name} = {value}", mend="give a positive number")


class AdmittanceController:
    """Commanded fingertips give way to force errors; joints follow by an iterated inverse.

    z_c = z_d + (f_nd - f_n + k_p z_e) / K_a + integral of (f_nd - f_n), where K_a is a stiffness.
    The fingertips' other coordinates stay as planned. The planned forces bend the servo's springs
    beforehand, as in :class:`pivotgait.control.position.PositionController`.

    Attributes:
        reference: the plan.
        gains: of law and servo.
        servo: of the robot.
        commanded_normals: (m,) z_c of the holding fingers in the last cycle [m].
    """

    def __init__(
        self,
        reference: Reference,
        gains: AdmittanceGains | None = None,
        *,
        period: float = 1e-3,
    ) -> None:
        """A controller of one run after another.

        Args:
            reference: the plan.
            gains: the default ones if not given.
            period: of the control cycle [s].
        """
        self.reference = reference
        self.gains = AdmittanceGains() if gains is None else gains
        robot = reference.robot
        self.servo = Servo(robot, reference.at(0.0).q, self.gains.tip_stiffness, period)
        self._period = period
        self._model, self._data = robot.model, robot.model.createData()
        self._rest = np.zeros(robot.nv)
        self._tasks = tuple(PhaseTask(robot, self._data, phase) for phase in reference.phases)
        self._chains = tuple(ClosedChain(robot, phase.holds) for phase in reference.phases)
        self.reset()

    def reset(self) -> None:
        """Forget integrals and offsets."""
        self._integral = dict.fromkeys(self.reference.robot.fingers, 0.0)
        self._offset = np.zeros(self.reference.robot.nv)
        self.commanded_normals = np.zeros(0)

    def torque(self, measurement: Measurement) -> Array:
        """(n,) torques of the servo towards the commanded positions."""
        wanted = self.reference.at(measurement.time)
        task, q, v = self._tasks[wanted.phase], measurement.q, measurement.v
        pin.computeJointJacobians(self._model, self._data, q)
        pin.forwardKinematics(self._model, self._data, q, v, self._rest)
        task.update(q, v, wanted)
        normal = measured_normal(task, wanted, measurement)
        self.commanded_normals = self._commanded(task, wanted, normal)
        self._move(wanted, self.commanded_normals)
        bent = contact_load(task, wanted, wanted.tool.rotation) / self.servo.stiffness
        commanded = wanted.q + self._offset + bent
        return self.servo.torque(q, v, commanded, wanted.v, touching_rows(task, wanted, normal))

    def _commanded(self, task: PhaseTask, wanted: Instant, normal: Array) -> Array:
        """(m,) z_c [m]."""
        gains = self.gains
        missing = planned_normal(task, wanted) - normal
        for name in self._integral.keys() - set(task.finger_names):
            self._integral[name] = 0.0
        for name, force in zip(task.finger_names, missing.tolist(), strict=True):
            moved = self._integral[name] + gains.integral * force * self._period
            self._integral[name] = min(max(moved, -LARGEST_OFFSET), LARGEST_OFFSET)
        lasting = np.array([self._integral[name] for name in task.finger_names])
        give = (missing + gains.position * task.error[task.z_rows]) / gains.admittance
        return np.clip(lasting + give, -LARGEST_OFFSET, LARGEST_OFFSET)

    def _move(self, wanted: Instant, commanded: Array) -> None:
        """Joint offsets from the plan that bring the fingertips to their commanded z."""
        chain = self._chains[wanted.phase]
        idle = list(self._tasks[wanted.phase].joint_columns)
        self._offset[idle] = 0.0
        if not chain.rows:
            return
        target = np.zeros(chain.rows)
        target[ROWS_PER_HOLD - 1 :: ROWS_PER_HOLD] = commanded
        lengths = chain.row_lengths()
        for _ in range(ITERATIONS):
            chain.update(wanted.q + self._offset, wanted.tool.rotation, wanted.tool.position)
            rows = chain.jacobian * lengths[:, None]
            rows[:, idle] = 0.0
            square = rows @ rows.T + INVERSE_DAMPING**2 * np.eye(chain.rows)
            self._offset += rows.T @ np.linalg.solve(square, lengths * (target - chain.residual))
