"""What the interior-point method minimises, on the slacks of a cone batch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import objectives
from pivotgait.forces.cone_batch import ConeBatch

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Goal:
    """``linear @ z`` plus a smooth objective of every contact force.

    Attributes:
        linear: (d,) or None.
        smooth: one of :data:`objectives.SMOOTH`, or None.
        weight: (c, B) weight of each contact in the smooth part, or None for 1.
    """

    linear: Array | None = None
    smooth: str | None = None
    weight: Array | None = None

    @property
    def unit(self) -> float:
        """Size below which the objective's digits no longer matter."""
        return 1e-3 if self.linear is None else 1.0

    def take(self, index: NDArray[np.intp]) -> Goal:
        """The goal of the problems at ``index``."""
        if self.weight is None:
            return self
        return Goal(self.linear, self.smooth, np.take(self.weight, index, axis=-1))

    def value(self, cones: ConeBatch, z: Array, s: Array) -> Array:
        """(B,) the goal at z with slacks s."""
        total = np.zeros(s.shape[1], dtype=s.dtype) if self.linear is None else self.linear @ z
        if self.smooth is not None:
            each = objectives.value(self.smooth, cones.contact_force(s))
            total = total + (each if self.weight is None else each * self.weight).sum(axis=0)
        return np.asarray(total)

    def slope(self, cones: ConeBatch, s: Array) -> Array:
        """(d, B) gradient by z."""
        total = np.zeros(cones.matrix.shape[1:], dtype=s.dtype)
        if self.linear is not None:
            total += self.linear[:, None]
        if self.smooth is not None:
            each = objectives.gradient(self.smooth, cones.contact_force(s))
            each[2] /= cones.head
            if self.weight is not None:
                each *= self.weight
            by_slack = each.reshape(3 * cones.cones, s.shape[1])
            total += np.einsum("qdb,qb->db", cones.matrix[: len(by_slack)], by_slack)
        return total

    def curvature(self, cones: ConeBatch, s: Array, *, concave: float) -> Array:
        """(3, 3, c, B) Hessian by the cone slacks; see :func:`objectives.hessian`."""
        each = objectives.hessian(str(self.smooth), cones.contact_force(s), concave=concave)
        each[2] /= cones.head
        each[:, 2] /= cones.head
        if self.weight is not None:
            each *= self.weight
        return each
