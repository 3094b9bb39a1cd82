"""How far the load of one grasp can grow along many directions at once: exact, by one batch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.limits import equation_matrix, limit_matrix
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal
from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.null_space import Inconsistent, Reduced, reduce
from pivotgait.forces.phase_one import FEASIBLE, phase_one
from pivotgait.forces.primal_dual import minimise, require_optimal
from pivotgait.frozen import Array, FrozenArrays

FAR = 1e4
"""Reach is cut off at so many force scales of the grasp: contacts may have no upper bound."""


@dataclass(frozen=True, eq=False)
class Rays(FrozenArrays):
    """Where rays from the load leave the set of wrenches that the contacts can apply.

    Attributes:
        direction: (D, 6) the rays, [force; moment].
        reach: (D,) largest s such that the wrench w + s direction can be applied.
        twist: (D, 6) outward normals t of the set there, t . direction = 1: no wrench v that can
            be applied has t . (v - w) > reach.
    """

    direction: Array
    reach: Array
    twist: Array


class RayShooter:
    """The set of wrenches around the load of one grasp, ready for any number of rays.

    Joint torque limits (rows) are kept exactly; contacts are exact cones.

    Args:
        grasps: one grasp.

    Attributes:
        inside: whether the load lies in the interior of the set, which then has six dimensions.

    Raises:
        InputError: for more than one grasp.
    """

    def __init__(self, grasps: Grasps) -> None:
        if grasps.count != 1:
            raise InputError(f"{grasps.count} grasps", mend="shoot rays from one at a time")
        form = local_form(grasps.problem)
        group = next(reduce(form, grasps.problem.wrench, grasps.friction))
        self.inside = False
        if isinstance(group, Inconsistent):
            return
        free = ~form.known[0].reshape(-1)
        equations = equation_matrix(form, group)[0][:, free]
        first = phase_one(group.cones, exact=True)
        full = np.linalg.matrix_rank(equations, tol=1e-8 * np.abs(equations).max()) == len(
            equations
        )
        self.inside = bool(first.shift[0] < -FEASIBLE and full)
        if self.inside:
            self._prepare(form, group, first.z, free, equations)

    def _prepare(
        self, form: LocalForm, group: Reduced, z: Array, free: Array, equations: Array
    ) -> None:
        self._limits = limit_matrix(form, group)[0]
        self._forces = np.zeros((len(free), 6))
        self._forces[free] = np.linalg.pinv(equations)[:, :6]
        self._back, self._free = np.linalg.pinv(equations.T), free
        self._cones, self._z, self._scale = group.cones, z, float(group.scale[0])

    def shoot(self, direction: Array) -> Rays:
        """Follow rays (D, 6), not zero, to the border of the set.

        Raises:
            InputError: the load is not inside the set.
            SolverError: a ray's program stalled.
        """
        if not self.inside:
            raise InputError("the load is not inside the wrenches of the grasp")
        direction = np.asarray(direction, dtype=float)
        size = np.linalg.norm(direction, axis=1)
        ways = direction / size[:, None]
        count, cones = len(ways), self._cones
        column = (self._limits @ self._forces @ ways.T)[:, None]
        many = cones.take(np.zeros(count, dtype=np.intp))
        matrix = np.concatenate((many.matrix, column), axis=1)
        stop = np.zeros((1, matrix.shape[1], count))
        stop[0, -1] = -1.0
        lifted = ConeBatch(
            np.concatenate((matrix, stop)),
            np.concatenate((many.offset, np.full((1, count), FAR))),
            many.head,
        )
        start = np.concatenate((np.repeat(self._z, count, axis=1), np.zeros((1, count))))
        goal = Goal(linear=np.append(np.zeros(len(self._z)), -1.0))
        end = minimise(lifted, goal, start)
        require_optimal(end)
        push = self._limits.T @ end.dual[:-1]
        twist = -(self._back @ push[self._free])[:6].T
        return Rays(direction, end.z[-1] * self._scale / size, twist / size[:, None])
