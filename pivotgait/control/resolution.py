"""Joint accelerations from task accelerations: the inverse of H, or the best within limits."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dgetrf, dgetrs, dposv

from pivotgait.control.joint_limits import JointLimits
from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.resistance import Resistance
from pivotgait.forces.resolution_qp import ResolutionQp
from pivotgait.frozen import Array
from pivotgait.models import Robot

NEAR_SINGULAR = 3e-3
"""Smallest singular value of the scaled H below which the plain inverse is left [m]."""
DAMPING = 1e-2
"""Weight of the planned posture in the weakest direction of a singular H [m]."""
LEAST_DAMPING = 1e-5
"""Weight of the planned posture in all directions, for programs that must be regular [m]."""
_ROUNDS = 2


class Resolution:
    """qddot of eqs (15)-(16), by one of three ways that join continuously.

    1. H is regular and no limit is met: qddot = H^-1 s_res.
    2. H comes near a singularity: qddot minimises |H qddot - s_res|^2 + rho^2 (w^T (qddot -
       posture))^2 in lengths (:class:`pivotgait.kinematics.TaskJacobian`). w is the direction that
       H hardly sees, rho grows from zero at ``NEAR_SINGULAR``, and the posture's accelerations
       lead back to the planned joint motion, which passes the singularity. All other directions
       keep their task.
    3. That would break a limit of a joint's position, speed or torque: the same within the limits,
       by ProxQP. Limits of motion leave room for what resists it
       (:class:`pivotgait.control.resistance.Resistance`).

    Attributes:
        cycles: solved by each of the three ways since ``reset``.
    """

    def __init__(self, robot: Robot, data: pin.Data) -> None:
        """Resolution of a robot's accelerations; ``data`` is scratch that the owner lends."""
        self._model, self._data = robot.model, data
        self.limits = JointLimits(robot)
        self._program = ResolutionQp(robot.nv, 2 * robot.nv)
        self._resistance = Resistance(robot.nv)
        self._start = np.full(robot.nv, robot.nv**-0.5)
        self._rows = np.zeros((2 * robot.nv, robot.nv))
        self.cycles = [0, 0, 0]

    def reset(self) -> None:
        """Forget warm starts and counts."""
        self._program.reset()
        self._resistance.reset()
        self.cycles = [0, 0, 0]

    def torque(
        self,
        task: PhaseTask,
        resolved: Array,
        posture: Array,
        measurement: Measurement,
        load: Array,
    ) -> Array:
        """(n,) torques of the resolved acceleration (eq. 17).

        Args:
            task: updated at the measured q and v.
            resolved: (n,) H qddot as eqs (12) and (14) ask for.
            posture: (n,) joint accelerations that lead back to the planned joint motion.
            measurement: of this cycle; later than that of the cycle before.
            load: (n,) J^T f.
        """
        time, q, v = measurement.time, measurement.q, measurement.v
        rows, columns = task.row_scale, task.column_scale
        matrix = rows[:, None] * task.matrix * columns
        wanted = rows * resolved
        factors, pivots, singular = dgetrf(matrix)
        nearness, weakest = 0.0, self._start
        if not singular:
            nearness, weakest = self._weakest_direction(factors, pivots)
        if nearness >= NEAR_SINGULAR:
            x, _ = dgetrs(factors, pivots, wanted)
            way, damping = 0, 0.0
        else:
            damping = DAMPING * (1.0 - nearness / NEAR_SINGULAR)
            _, x, _ = dposv(
                *_normal_equations(matrix, wanted, posture / columns, damping * weakest)
            )
            way = 1
        qddot = columns * x
        tau = np.asarray(pin.rnea(self._model, self._data, q, v, qddot) + load)
        lower, upper = self._motion_bounds(time, q, v)
        if _within(qddot, lower, upper) and _within(tau, -self.limits.effort, self.limits.effort):
            self.cycles[way] += 1
            self._resistance.ask(time, v, qddot)
            return tau
        self.cycles[2] += 1
        equations = _normal_equations(matrix, wanted, posture / columns, damping * weakest)
        qddot, tau = self._within_limits(equations, columns, (lower, upper), q, v, load)
        self._resistance.ask(time, v, qddot)
        return tau

    def _motion_bounds(self, time: float, q: Array, v: Array) -> tuple[Array, Array]:
        """(n,) least and largest accelerations to ask for, resistance overcome."""
        self._resistance.observe(time, v)
        resisted = self._resistance.acceleration
        lower, upper = self.limits.acceleration_bounds(q, v)
        return lower + np.minimum(resisted, 0.0), upper + np.maximum(resisted, 0.0)

    def _weakest_direction(self, factors: Array, pivots: Array) -> tuple[float, Array]:
        """Smallest singular value [m], never too small, and its direction (n,).

        By inverse iteration from a fixed start.
        """
        x, norm = self._start, 1.0
        for _ in range(_ROUNDS):
            x, _ = dgetrs(factors, pivots, x, trans=1)
            x, _ = dgetrs(factors, pivots, x)
            norm = float(x.dot(x) ** 0.5)
            x /= norm
        return norm**-0.5, x

    def _within_limits(
        self,
        equations: tuple[Array, Array],
        columns: Array,
        bounds: tuple[Array, Array],
        q: Array,
        v: Array,
        load: Array,
    ) -> tuple[Array, Array]:
        """Accelerations and torques of the program; without an answer, of the damped one, cut."""
        hessian, right = equations
        effort, n = self.limits.effort, len(q)
        inertia = np.array(pin.crba(self._model, self._data, q))
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        bias = np.asarray(pin.nonLinearEffects(self._model, self._data, q, v)) + load
        self._rows[:n] = np.diag(columns)
        self._rows[n:] = inertia * columns / effort[:, None]
        lower = np.concatenate((bounds[0], -1.0 - bias / effort))
        upper = np.concatenate((bounds[1], 1.0 - bias / effort))
        x = self._program.solve(hessian, -right, self._rows, lower, upper)
        if x is None:
            _, x, _ = dposv(hessian, right)
        qddot = columns * x
        return qddot, np.asarray(np.clip(inertia.dot(qddot) + bias, -effort, effort))


def _normal_equations(
    matrix: Array, wanted: Array, posture: Array, damped: Array
) -> tuple[Array, Array]:
    """P and g of min 1/2 x^T P x - g^T x; ``damped`` is the direction times its weight [m]."""
    least = LEAST_DAMPING * LEAST_DAMPING
    hessian = matrix.T.dot(matrix)
    hessian += damped[:, None] * damped
    hessian.flat[:: len(hessian) + 1] += least
    right = matrix.T.dot(wanted) + least * posture
    return hessian, right + damped * damped.dot(posture)


def _within(values: Array, lower: Array, upper: Array) -> bool:
    return bool((values >= lower).all() and (values <= upper).all())
