"""B small conic problems of one shape: K z + k in a product of friction cones and half-lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import cone_algebra as algebra

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ConeBatch:
    """Slacks s = matrix @ z + offset of B problems, batch first.

    The first 3 c slacks are c cones (t_x, t_y, head), the others non-negative scalars.

    Attributes:
        matrix: (B, q, d).
        offset: (B, q).
        head: (B, c) the head of each cone over the contact's normal force (its friction).
    """

    matrix: Array
    offset: Array
    head: Array

    @property
    def cones(self) -> int:
        """Number of cones c."""
        return int(self.head.shape[1])

    @property
    def degree(self) -> int:
        """Barrier degree: one per cone and one per scalar."""
        return int(self.matrix.shape[1]) - 2 * self.cones

    def take(self, index: NDArray[np.intp]) -> ConeBatch:
        """The problems at ``index``."""
        return ConeBatch(self.matrix[index], self.offset[index], self.head[index])

    def slack(self, z: Array) -> Array:
        """(B, q) slacks at z (B, d)."""
        return self.offset + self.image(z)

    def image(self, dz: Array) -> Array:
        """(B, q) change of the slacks by dz (B, d)."""
        return np.asarray((self.matrix @ dz[..., None])[..., 0])

    def transposed(self, dual: Array) -> Array:
        """(B, d) matrix' @ dual."""
        return np.asarray((dual[:, None] @ self.matrix)[:, 0])

    def split(self, s: Array) -> tuple[Array, Array]:
        """Views of slacks or duals: cones (B, c, 3) and scalars (B, q - 3 c)."""
        c = self.cones
        return s[:, : 3 * c].reshape(len(s), c, 3), s[:, 3 * c :]

    def contact_force(self, s: Array) -> Array:
        """(B, c, 3) contact coordinates (t_x, t_y, n) of the cone slacks."""
        x = np.array(self.split(s)[0])
        x[..., 2] /= self.head
        return x

    def pull_back(self, gradient: Array) -> Array:
        """(B, q) gradient on the slacks from one (B, c, 3) on the contact forces."""
        out = np.zeros(self.offset.shape)
        cone = self.split(out)[0]
        cone[...] = gradient
        cone[..., 2] /= self.head
        return out

    def interior(self, s: Array) -> Array:
        """(B,) smallest margin of any cone or scalar."""
        cone, scalar = self.split(s)
        least = np.concatenate((algebra.margin(cone), scalar), axis=1)
        return np.asarray(least.min(axis=1))

    def inside(self, s: Array) -> Mask:
        """(B,) whether slacks or duals are strictly interior; NaN is not."""
        cone, line = self.split(s)
        good = np.all(algebra.margin(cone) > 0.0, axis=1)
        return np.asarray(good & np.all(line > 0.0, axis=1))

    def log_barrier(self, s: Array) -> tuple[Mask, Array]:
        """(B,) whether inside, and (B,) -1/2 log det of the cones - log of the scalars there."""
        cone, line = self.split(s)
        det = np.where(cone[..., 2] > 0.0, algebra.determinant(cone), -1.0)
        inside = np.all(det > 0.0, axis=1) & np.all(line > 0.0, axis=1)
        if not inside.all():
            det = np.where(inside[:, None], det, 1.0)
            line = np.where(inside[:, None], line, 1.0)
        product = np.sqrt(det.prod(axis=1)) * line.prod(axis=1)
        # A product of a dozen factors is one logarithm, unless it underflows.
        if np.all(product > 1e-250) and np.all(np.isfinite(product)):
            return inside, -np.log(product)
        return inside, -0.5 * np.log(det).sum(axis=1) - np.log(line).sum(axis=1)

    def inverse(self, s: Array) -> Array:
        """(B, q) inverse of interior slacks: minus the gradient of the barrier."""
        cone, line = self.split(s)
        out = np.empty_like(s)
        inverse_cone, inverse_line = self.split(out)
        inverse_cone[...] = algebra.reflect(cone) / algebra.determinant(cone)[..., None]
        inverse_line[...] = 1.0 / line
        return out
