"""B small conic problems of one shape: K z + k in a product of friction cones and half-lines.

The batch is the last axis of every array, so that numpy's loops run along memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import cone_algebra as algebra

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ConeBatch:
    """Slacks s = matrix @ z + offset of B problems.

    The first 3 c slacks are the t_x of c cones, their t_y and their heads; the others are
    non-negative scalars.

    Attributes:
        matrix: (q, d, B).
        offset: (q, B).
        head: (c, B) the head of each cone over the contact's normal force (its friction).
    """

    matrix: Array
    offset: Array
    head: Array

    @property
    def cones(self) -> int:
        """Number of cones c."""
        return int(self.head.shape[0])

    @property
    def degree(self) -> int:
        """Barrier degree: one per cone and one per scalar."""
        return int(self.matrix.shape[0]) - 2 * self.cones

    def take(self, index: NDArray[np.intp]) -> ConeBatch:
        """The problems at ``index``."""
        return ConeBatch(
            np.take(self.matrix, index, axis=-1),
            np.take(self.offset, index, axis=-1),
            np.take(self.head, index, axis=-1),
        )

    def astype(self, precision: type[Any]) -> ConeBatch:
        """The problems in another floating-point precision."""
        parts = (self.matrix, self.offset, self.head)
        return ConeBatch(*(cast(Array, part.astype(precision, copy=False)) for part in parts))

    def slack(self, z: Array) -> Array:
        """(q, B) slacks at z (d, B)."""
        return self.offset + self.image(z)

    def image(self, dz: Array) -> Array:
        """(q, B) change of the slacks by dz (d, B)."""
        return np.asarray(np.einsum("qdb,db->qb", self.matrix, dz))

    def transposed(self, dual: Array) -> Array:
        """(d, B) matrix' @ dual."""
        return np.asarray(np.einsum("qdb,qb->db", self.matrix, dual))

    def split(self, s: Array) -> tuple[Array, Array]:
        """Views of slacks or duals: cones (3, c, B) and scalars (q - 3 c, B)."""
        c = self.cones
        return s[: 3 * c].reshape(3, c, s.shape[1]), s[3 * c :]

    def contact_force(self, s: Array) -> Array:
        """(3, c, B) contact coordinates (t_x, t_y, n) of the cone slacks."""
        x = np.array(self.split(s)[0])
        x[2] /= self.head
        return x

    def interior(self, s: Array) -> Array:
        """(B,) smallest margin of any cone or scalar."""
        cone, line = self.split(s)
        return np.asarray(np.concatenate((algebra.margin(cone), line)).min(axis=0, initial=np.inf))

    def inside(self, s: Array) -> Mask:
        """(B,) whether slacks or duals are strictly interior; NaN is not."""
        return np.asarray(self.interior(s) > 0.0)

    def log_barrier(self, s: Array) -> tuple[Mask, Array]:
        """(B,) whether inside, and (B,) -1/2 log det of the cones - log of the scalars there."""
        cone, line = self.split(s)
        det = np.where(cone[2] > 0.0, algebra.determinant(cone), -1.0)
        inside = np.all(det > 0.0, axis=0) & np.all(line > 0.0, axis=0)
        if not inside.all():
            det, line = np.where(inside, det, 1.0), np.where(inside, line, 1.0)
        return inside, interior_log_barrier(det, line)

    def inverse(self, s: Array) -> Array:
        """(q, B) inverse of interior slacks: minus the gradient of the barrier."""
        cone, line = self.split(s)
        out = np.empty_like(s)
        inverse_cone, inverse_line = self.split(out)
        inverse_cone[...] = algebra.reflect(cone) / algebra.determinant(cone)
        inverse_line[...] = 1.0 / line
        return out


def interior_log_barrier(det: Array, line: Array) -> Array:
    """(B,) the barrier of determinants (c, B) and scalars, all positive."""
    # A product of a dozen factors takes one logarithm, unless it leaves the range.
    with np.errstate(over="ignore"):
        product = np.sqrt(det.prod(axis=0)) * line.prod(axis=0)
    span = np.finfo(product.dtype)
    if product.min() > 1e3 * span.tiny and product.max() < 1e-3 * span.max:
        return np.asarray(-np.log(product))
    return np.asarray(-0.5 * np.log(det).sum(axis=0) - np.log(line).sum(axis=0))
