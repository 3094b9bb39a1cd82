"""Forces and torsional moments of soft fingertips that carry a tool: one conic program.

A point contact bears no moment; two of them leave the tool free to turn about the line through
them. A soft fingertip presses on a patch and resists spin about its normal as well. Its limit
surface is taken for an ellipsoid (R. D. Howe, M. R. Cutkosky, "Practical force-motion models for
sliding manipulation", IJRR 15(6), 1996):

    |f_t|^2 / (mu f_n)^2 + m^2 / (e f_n)^2 <= 1

with the coefficient of torsional friction e [m]. In the coordinates (t_x, t_y, mu m / e) that is
Coulomb's cone (Xue et al., eq. 5) with one dimension more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.forces.clarabel_ import optimum
from pivotgait.frozen import Array, FrozenArrays

Index = NDArray[np.intp]
COORDINATES = 4
"""Of a soft contact: two tangents, the normal, and mu m / e."""


@dataclass(frozen=True, eq=False)
class SoftFingerProblem(FrozenArrays):
    """T samples of m soft fingers that apply a wrench; vectors in one common frame.

    Attributes:
        names: of the m fingers.
        lever: (T, m, 3) contact points relative to the centre of mass [m].
        normals: (T, m, 3) inward unit normals.
        friction: (m,) Coulomb coefficients mu.
        torsion: (m,) coefficients of torsional friction e [m]; 0 for a point contact.
        normal_min: (m,) lower bounds of the normal force [N].
        normal_max: (m,) upper bounds [N].
        wrench: (T, 6) force [N] and moment about the centre of mass [N m] that they apply.
        start: (m, 3) forces at the first sample [N], where no finger bears a moment.
        force_rate_max: bound of |(df, dm / e)| / step_s for each finger [N/s].
        step_s: time between samples [s].

    Raises:
        InputError: for shapes that do not fit or numbers that cannot be.
    """

    names: tuple[str, ...]
    lever: Array
    normals: Array
    friction: Array
    torsion: Array
    normal_min: Array
    normal_max: Array
    wrench: Array
    start: Array
    force_rate_max: float
    step_s: float

    def __post_init__(self) -> None:
        super().__post_init__()
        t, m = len(self.wrench), len(self.names)
        wanted: dict[str, tuple[int, ...]] = {
            "lever": (t, m, 3),
            "normals": (t, m, 3),
            "friction": (m,),
            "torsion": (m,),
            "normal_min": (m,),
            "normal_max": (m,),
            "wrench": (t, 6),
            "start": (m, 3),
        }
        for name, shape in wanted.items():
            value = getattr(self, name)
            if value.shape != shape or not np.all(np.isfinite(value)):
                what = f"{name} has shape {value.shape} or is not finite"
                raise InputError(what, where="soft fingers", mend=f"give finite {shape}")
        if not (np.all(self.friction > 0.0) and np.all(self.torsion >= 0.0)):
            mend = "give friction above 0 and torsion of 0 or more"
            raise InputError("a coefficient is negative", where="soft fingers", mend=mend)


@dataclass(frozen=True, eq=False)
class SoftFingerForces(FrozenArrays):
    """What soft fingers apply.

    Attributes:
        force: (T, m, 3) in the problem's frame [N].
        moment: (T, m) about the inward normals [N m].
        iterations: of the solver.
    """

    force: Array
    moment: Array
    iterations: int


def allocate_soft(problem: SoftFingerProblem) -> SoftFingerForces:
    """Forces and moments that minimise the sum of (|f_t|^2 + (mu m / e)^2) / f_n.

    Convex, as the objective ``tangential`` of point contacts, which it is without torsion. All
    samples are one program, since forces may change only so fast.

    Raises:
        InfeasibleError: no such forces.
        SolverError: the solver failed otherwise.
    """
    program = _Program(problem)
    v, steps = optimum(*program.standard_form())
    if v is None:
        raise InfeasibleError(
            "no forces of the fingers carry the tool",
            mend="move contacts so that the centre of mass is in the vertical plane through them, "
            "or give contacts more normal force, friction or torsion_m",
        )
    t, m = problem.wrench.shape[0], len(problem.names)
    x = v[: t * m * COORDINATES].reshape(t, m, COORDINATES)
    force = (program.frames @ x[..., :3, None])[..., 0]
    return SoftFingerForces(force, x[..., 3] * program.spin, steps)


class _Program:
    """minimise sum u subject to A v + s = b, s in cones; v holds (T, m, 4) x, (T - 1, m) u."""

    def __init__(self, problem: SoftFingerProblem) -> None:
        self.problem = problem
        self.samples, self.fingers = len(problem.wrench), len(problem.names)
        self.frames = contact_frame(problem.normals)
        self.spin = problem.torsion / problem.friction
        """(m,) moment of a unit of the fourth coordinate [m]."""
        shape = (self.samples, self.fingers, COORDINATES)
        self.place: Index = np.arange(int(np.prod(shape))).reshape(shape)
        self.bound: Index = self.place.size + np.arange((self.samples - 1) * self.fingers)
        self._blocks: list[tuple[str, Array, Index, Array]] = []
        self._equations()
        self._bounds()
        self._cones()
        self._rates()

    def _add(self, kind: str, matrix: Array, columns: Index, constant: Array) -> None:
        """C groups of rows: constant (C, r) + matrix (C, r, w) @ v[columns (C, w)] in a cone."""
        self._blocks.append((kind, matrix, columns, constant))

    def _equations(self) -> None:
        """The start as given; from then on the wrench (eq. 3, with the fingers' moments)."""
        p, m = self.problem, self.fingers
        local = np.einsum("mji,mj->mi", self.frames[0], p.start)
        first = np.concatenate((local, np.zeros((m, 1))), axis=1).reshape(1, -1)
        size = m * COORDINATES
        self._add("zero", np.eye(size)[None], self.place[:1].reshape(1, -1), -first)
        grasp = grasp_map(p.lever).reshape(self.samples, 6, m, 3)
        rows = np.zeros((self.samples, 6, m, COORDINATES))
        rows[..., :3] = np.einsum("tamj,tmjk->tamk", grasp, self.frames)
        rows[:, 3:, :, 3] = np.swapaxes(p.normals * self.spin[:, None], 1, 2)
        columns = self.place.reshape(self.samples, -1)[1:]
        self._add("zero", rows.reshape(self.samples, 6, size)[1:], columns, -p.wrench[1:])
        if np.any(self.spin == 0.0):
            stiff = self.place[1:, self.spin == 0.0, 3].reshape(-1, 1)
            self._add("zero", np.ones((len(stiff), 1, 1)), stiff, np.zeros((len(stiff), 1)))

    def _bounds(self) -> None:
        normal = self.place[1:, :, 2].reshape(-1, 1)
        for bound, sign in ((self.problem.normal_min, 1.0), (self.problem.normal_max, -1.0)):
            side = np.tile(-sign * bound, self.samples - 1)[:, None]
            self._add("nonnegative", np.full((len(normal), 1, 1), sign), normal, side)

    def _cones(self) -> None:
        """|(t_x, t_y, w)| <= mu n, and the objective's |(t_x, t_y, w)|^2 <= n u."""
        count = (self.samples - 1) * self.fingers
        x = self.place[1:].reshape(count, COORDINATES)
        u = self.bound[:, None]
        friction = np.zeros((count, 4, COORDINATES))
        friction[:, 0, 2] = np.tile(self.problem.friction, self.samples - 1)
        friction[:, [1, 2, 3], [0, 1, 3]] = 1.0
        self._add("cone", friction, x, np.zeros((count, 4)))
        square = np.zeros((count, 5, COORDINATES + 1))
        square[:, 0, [2, 4]] = 1.0
        square[:, 1, [2, 4]] = 1.0, -1.0
        square[:, [2, 3, 4], [0, 1, 3]] = 2.0
        self._add("cone", square, np.concatenate((x, u), axis=1), np.zeros((count, 5)))

    def _rates(self) -> None:
        """|(df, dm / e)| <= rate * step; w = mu m / e is mu times too large for that."""
        p, count = self.problem, (self.samples - 1) * self.fingers
        change = np.zeros((self.samples - 1, self.fingers, 5, 2 * COORDINATES))
        change[:, :, 1:4, :3], change[:, :, 1:4, 4:7] = self.frames[1:], -self.frames[:-1]
        change[:, :, 4, 3], change[:, :, 4, 7] = 1.0 / p.friction, -1.0 / p.friction
        columns = np.concatenate((self.place[1:], self.place[:-1]), axis=-1)
        constant = np.zeros((count, 5))
        constant[:, 0] = p.force_rate_max * p.step_s
        shape = (count, 5, 2 * COORDINATES)
        self._add("cone", change.reshape(shape), columns.reshape(count, -1), constant)

    def standard_form(self) -> tuple[Any, Array, Any, Array, list[Any]]:
        """Curvature, linear cost, A, b and cones as :func:`optimum` takes them."""
        import clarabel
        from scipy.sparse import coo_matrix, csc_matrix

        width = self.place.size + self.bound.size
        rows, columns, entries, cones = [], [], [], []
        sides, offset = [], 0
        for kind, matrix, column, constant in self._blocks:
            count, high, _ = matrix.shape
            row = offset + np.arange(count * high).reshape(count, high, 1)
            rows.append(np.broadcast_to(row, matrix.shape).ravel())
            columns.append(np.broadcast_to(column[:, None], matrix.shape).ravel())
            entries.append(-matrix.ravel())
            sides.append(constant.ravel())
            offset += count * high
            if kind == "cone":
                cones += [clarabel.SecondOrderConeT(high)] * count
            else:
                cone = clarabel.ZeroConeT if kind == "zero" else clarabel.NonnegativeConeT
                cones.append(cone(count * high))
        place = (np.concatenate(rows), np.concatenate(columns))
        sparse = csc_matrix(coo_matrix((np.concatenate(entries), place), shape=(offset, width)))
        sparse.eliminate_zeros()
        linear = np.zeros(width)
        linear[self.bound] = 1.0
        return csc_matrix((width, width)), linear, sparse, np.concatenate(sides), cones
