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
        weight: (B, c) weight of each contact in the smooth part, or None for 1.
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
        return Goal(self.linear, self.smooth, self.weight[index])

    def value(self, cones: ConeBatch, z: Array, s: Array) -> Array:
        """(B,) the goal at z with slacks s."""
        total = np.zeros(len(s)) if self.linear is None else z @ self.linear
        if self.smooth is not None:
            each = objectives.value(self.smooth, cones.contact_force(s))
            total = total + (each if self.weight is None else each * self.weight).sum(axis=1)
        return np.asarray(total)

    def slope(self, cones: ConeBatch, s: Array) -> Array:
        """(B, d) gradient by z."""
        total = np.zeros((len(s), cones.matrix.shape[2]))
        if self.linear is not None:
            total += self.linear
        if self.smooth is not None:
            each = objectives.gradient(self.smooth, cones.contact_force(s))
            if self.weight is not None:
                each *= self.weight[..., None]
            total += cones.transposed(cones.pull_back(each))
        return total

    def curvature(self, cones: ConeBatch, s: Array, *, concave: float) -> Array:
        """(B, c, 3, 3) Hessian by the cone slacks; see :func:`objectives.hessian`."""
        each = objectives.hessian(str(self.smooth), cones.contact_force(s), concave=concave)
        head = cones.head[..., None]
        each[..., 2, :] /= head
        each[..., :, 2] /= head
        if self.weight is not None:
            each *= self.weight[..., None, None]
        return each
