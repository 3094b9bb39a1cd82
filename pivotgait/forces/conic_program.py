"""A whole allocation problem, coupled rows included, as one sparse conic program.

minimise 1/2 v' P v + q' v  subject to  b - A v in a product of cones, with v the free contact
coordinates of all samples and, behind them, auxiliary variables.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import cone_margin
from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.problem import AllocationProblem

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
Kind = Literal["zero", "nonnegative", "cone"]
GIVEN_TOLERANCE = 1e-6
"""Prescribed end forces may miss their constraints by this [N, N m]: an earlier solve's rest."""


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of b - A v, as triplets.

    Attributes:
        kind: ``zero`` and ``nonnegative`` rows, or ``cone``: second-order cones, head first.
        size: dimension of each cone (1 for other kinds).
        row: row of each entry within the block.
        column: its column among all 3 m T coordinates and the auxiliary variables.
        entry: its value in b - A v (that is, -A).
        constant: (rows,) b.
    """

    kind: Kind
    size: int
    row: Index
    column: Index
    entry: Array
    constant: Array


@dataclass(eq=False)
class ConicProgram:
    """Builds the rows of a problem; :meth:`assemble` makes matrices of them.

    Attributes:
        problem: the allocation problem.
        form: its contact coordinates.
        friction: (T, m) friction, which the caller may scale.
        auxiliary: number of auxiliary variables.
        blocks: the rows so far.
    """

    problem: AllocationProblem
    form: LocalForm
    friction: Array
    auxiliary: int = 0
    blocks: list[Block] = field(default_factory=list)

    @classmethod
    def of(cls, problem: AllocationProblem) -> ConicProgram:
        """The program's variables, without rows; prescribed end forces become known values."""
        form = local_form(problem)
        for k, force in ((0, problem.start), (-1, problem.end)):
            if force is not None:
                form.known[k] = True
                form.value[k] = (np.swapaxes(form.frames[k], -1, -2) @ force[..., None])[..., 0]
        shape = (problem.samples, problem.contacts)
        return cls(problem, form, np.broadcast_to(problem.friction, shape))

    @property
    def given(self) -> Mask:
        """(T,) samples whose forces are all prescribed by ``start`` or ``end``."""
        out = np.zeros(self.problem.samples, dtype=bool)
        out[0] = self.problem.start is not None
        out[-1] |= self.problem.end is not None
        return out

    @property
    def loaded(self) -> Mask:
        """(T, m) contacts that carry a force and have unknown coordinates."""
        return np.asarray(~self.form.known.all(axis=-1))

    def given_fits(self) -> bool:
        """Whether prescribed end forces satisfy the rows of their own samples."""
        k = np.nonzero(self.given)[0]
        if k.size == 0:
            return True
        p, x = self.problem, self.form.value[k]
        force = self.form.world(self.form.value)[k]
        flat = x.reshape(len(k), -1, 1)
        ramp = np.nan_to_num(p.fixed[k], nan=-1.0)
        violations = [
            np.abs((self.form.grasp[k] @ flat)[..., 0] - p.wrench[k]),
            -cone_margin(force, p.normals[k], p.friction),
            np.where(p.loaded[k], p.normal_min[k], 0.0) - x[..., 2],
            x[..., 2] - p.normal_max[k],
            np.where(ramp >= 0.0, np.abs(x[..., 2] - ramp), 0.0),
            self.form.lower[k] - (self.form.rows[k] @ flat)[..., 0],
            (self.form.rows[k] @ flat)[..., 0] - self.form.upper[k],
        ]
        return bool(max(v.max(initial=0.0) for v in violations) <= GIVEN_TOLERANCE)

    def column(self, sample: Index, contact: Index, axis: int) -> Index:
        """Columns of contact coordinates."""
        return np.asarray((sample * self.problem.contacts + contact) * 3 + axis, dtype=np.intp)

    def add_auxiliary(self, count: int) -> Index:
        """Columns of new auxiliary variables."""
        first = self.form.value.size + self.auxiliary
        self.auxiliary += count
        return np.arange(first, first + count)

    def add_dense(self, kind: Kind, matrix: Array, constant: Array, sample: Index) -> None:
        """Rows matrix (S, r, 3 m) @ x_k + constant (S, r) of the samples ``sample`` (S,)."""
        count, rows, columns = matrix.shape
        row = np.arange(count * rows).reshape(count, rows, 1)
        column = sample[:, None, None] * columns + np.arange(columns)
        shape = matrix.shape
        self.blocks.append(
            Block(
                kind,
                1,
                np.broadcast_to(row, shape).reshape(-1),
                np.broadcast_to(column, shape).reshape(-1),
                matrix.reshape(-1),
                constant.reshape(-1),
            )
        )

    def add_rows(self) -> None:
        """The wrench (eq. 3), the bounds (eq. 6) and the linear rows."""
        form = self.form
        sample = np.nonzero(~self.given)[0]
        self.add_dense("zero", form.grasp[sample], -self.problem.wrench[sample], sample)
        for bound, sign in ((form.low, 1.0), (form.high, -1.0)):
            k, i = np.nonzero(~np.isnan(bound) & ~self.given[:, None])
            column = self.column(k, i, 2)
            side = -sign * bound[k, i]
            row = np.arange(len(k))
            self.blocks.append(Block("nonnegative", 1, row, column, np.full(len(k), sign), side))
        equal = form.lower == form.upper
        for limit, sign, kind in (
            (np.where(equal, form.lower, np.inf), 1.0, "zero"),
            (np.where(equal, np.inf, form.lower), 1.0, "nonnegative"),
            (np.where(equal, np.inf, form.upper), -1.0, "nonnegative"),
        ):
            k, r = np.nonzero(np.isfinite(limit) & ~self.given[:, None])
            if k.size:
                matrix, side = sign * form.rows[k, r][:, None], -sign * limit[k, r][:, None]
                self.add_dense("zero" if kind == "zero" else "nonnegative", matrix, side, k)

    def add_friction(self, shift: Index | None = None, weight: Array | None = None) -> None:
        """The cones |f_t| <= mu f_n (eq. 5), plus ``weight`` (T, m) times a shift variable."""
        k, i = np.nonzero(self.loaded & ~self.given[:, None])
        cone = np.arange(len(k)) * 3
        row = np.concatenate((cone, cone + 1, cone + 2))
        column = np.concatenate([self.column(k, i, axis) for axis in (2, 0, 1)])
        entry = np.concatenate((self.friction[k, i], np.ones(2 * len(k))))
        if shift is not None and weight is not None:
            row = np.concatenate((row, cone))
            column = np.concatenate((column, np.broadcast_to(shift, len(k))))
            entry = np.concatenate((entry, weight[k, i]))
        self.blocks.append(Block("cone", 3, row, column, entry, np.zeros(3 * len(k))))

    def add_rate(self) -> None:
        """The cones |f_k - f_(k-1)| <= rate * step of every contact."""
        p = self.problem
        if p.force_rate_max is None or p.step_s is None or p.samples < 2:
            return
        t, m = p.samples, p.contacts
        cone = np.arange((t - 1) * m).reshape(t - 1, m, 1, 1) * 4
        row = cone + 1 + np.arange(3)[:, None]
        place = np.arange(t * m * 3).reshape(t, m, 1, 3)
        shape = (t - 1, m, 3, 3)
        constant = np.zeros((t - 1, m, 4))
        constant[..., 0] = p.force_rate_max * p.step_s

        def flat(now: NDArray[Any], before: NDArray[Any]) -> NDArray[Any]:
            pair = [np.broadcast_to(part, shape).reshape(-1) for part in (now, before)]
            return np.concatenate(pair)

        rows, columns = flat(row, row), flat(place[1:], place[:-1])
        entries = flat(self.form.frames[1:], -self.form.frames[:-1])
        self.blocks.append(Block("cone", 4, rows, columns, entries, constant.reshape(-1)))

    def add_tangential(self) -> Index:
        """Auxiliary u >= |f_t|^2 / f_n of every loaded contact, as cones; returns their columns."""
        k, i = np.nonzero(self.loaded & ~self.given[:, None])
        u = self.add_auxiliary(len(k))
        cone = np.arange(len(k)) * 4
        normal = self.column(k, i, 2)
        row = np.concatenate((cone, cone, cone + 1, cone + 1, cone + 2, cone + 3))
        column = np.concatenate((normal, u, normal, u, self.column(k, i, 0), self.column(k, i, 1)))
        one = np.ones(len(k))
        entry = np.concatenate((one, one, one, -one, 2.0 * one, 2.0 * one))
        self.blocks.append(Block("cone", 4, row, column, entry, np.zeros(4 * len(k))))
        return u

    @property
    def free(self) -> Mask:
        """(3 m T + auxiliary,) which columns are unknown."""
        return np.concatenate((~self.form.known.reshape(-1), np.ones(self.auxiliary, dtype=bool)))
