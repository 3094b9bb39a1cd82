"""One cone program of the successive ones: the removal linearised about a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial.transform import Rotation

from pivotgait.contacts.grasp_map import skew
from pivotgait.exceptions import SolverError
from pivotgait.frozen import FrozenArrays
from pivotgait.phases.removal_linearised import (
    Rows,
    Trajectory,
    dynamics,
    left_jacobian,
    slope,
)
from pivotgait.phases.removal_packing import BOUND_RESERVE_N, FRICTION_RESERVE
from pivotgait.phases.removal_problem import RemovalProblem

Array = NDArray[np.float64]

COST_SCALE = 30.0
"""The cost of a good removal is 1e-3 to 1e-1: scaled to about 1."""
PENALTY = 1e4
"""Cost (scaled) of 1 N m of moment residual: well above the multipliers met.

With 1e3, turns of 20 degrees end with a moment left; with 1e5, Clarabel runs into trouble.
"""
FORCE = 0.1
"""Weight of 1 N of table force beyond what balance allows, against 1 N m."""


@dataclass(frozen=True)
class _Layout:
    """Where the variables of stage k = 1..K stand: a, omega, sigma, table, fingers, slacks."""

    steps: int
    fingers: int

    @property
    def width(self) -> int:
        return 12 + 3 * self.fingers + 12

    @property
    def size(self) -> int:
        return self.steps * self.width

    def at(self, first: int, count: int) -> NDArray[np.intp]:
        """(K, count) columns from offset ``first`` of each stage."""
        return np.arange(self.steps)[:, None] * self.width + first + np.arange(count)


@dataclass(frozen=True, eq=False)
class Bend(FrozenArrays):
    """What linearised rows miss at the end of a step: the true values less the linear ones.

    Attributes:
        moment: (K, 3) of the moment about the pivot [N m].
        table: (K, 3) of the table's force, world [N].
        rise: (K, P) of the heights of the points to keep clear, over the pivot [m].
    """

    moment: Array
    table: Array
    rise: Array


@dataclass(frozen=True, eq=False)
class Step:
    """What a round proposes.

    Attributes:
        trajectory: the new one.
        model: value of the round's model of cost and penalty there (scaled).
        turn: largest change of orientation [rad].
        optimality: violation of stationarity that the step removes, in units of the cost.
        bend: what the linearised rows missed at its end.
    """

    trajectory: Trajectory
    model: float
    turn: float
    optimality: float
    bend: Bend


class Round:
    """One cone program: the problem linearised about a trajectory."""

    def __init__(self, problem: RemovalProblem, trajectory: Trajectory, radius: float) -> None:
        self.problem, self.nominal, self.radius = problem, trajectory, radius
        self.layout = _Layout(problem.steps, problem.staying + 1)
        at, fingers = self.layout.at, self.layout.fingers
        self.a, self.omega, self.sigma = at(0, 3), at(3, 3), at(6, 3)
        self.table = at(9, 3)
        # residuals of moment [N m] and table force [N]: positive and negative parts
        self.slack, self.give = at(12 + 3 * fingers, 6), at(18 + 3 * fingers, 6)
        self.push = at(12, 3 * fingers).reshape(-1, fingers, 3)
        self.state = dynamics(problem, trajectory)

    def solve(self, bend: Bend | None = None) -> Step:
        """Solve it and return the new trajectory with the model's value there.

        Args:
            bend: of an earlier step of this round; added to the rows, it makes them exact at
                that step's end: a second-order correction (Nocedal and Wright, Numerical
                Optimization, 2nd ed., section 18.3), against the Maratos effect.
        """
        import clarabel

        if bend is None:
            still = np.zeros((self.problem.steps, 3))
            bend = Bend(still, still, np.zeros((self.problem.steps, len(self.problem.clear_rise))))
        quadratic, linear, constant = self._cost()
        rows = Rows(self.layout.size)
        cones: list[Any] = [clarabel.ZeroConeT(self._equalities(rows, bend))]
        cones.append(clarabel.NonnegativeConeT(self._inequalities(rows, bend)))
        cones += [clarabel.SecondOrderConeT(3)] * self._cones(rows)
        if self.problem.rated:
            cones += [clarabel.SecondOrderConeT(4)] * self._rates(rows)
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
        answer = clarabel.DefaultSolver(
            sparse.triu(quadratic, format="csc"),
            linear,
            rows.matrix(),
            np.concatenate(rows.side),
            cones,
            settings,
        ).solve()
        x = np.array(answer.x)
        # an inexact answer near the end is only a proposal: the merit function judges it
        usable = {"Solved", "AlmostSolved", "InsufficientProgress"}
        if str(answer.status) not in usable or not np.isfinite(x).all():
            raise SolverError(
                f"a cone program of the removal ended as {answer.status}",
                where="removal",
                mend="try the solver fatrop",
            )
        sigma, local = x[self.sigma].copy(), x[self.push].copy()
        sigma[-1] = 0.0
        before = self._point()
        step = np.where(np.isnan(before), 0.0, x - before)
        trajectory = Trajectory.of(self.problem, sigma, local)
        return Step(
            trajectory,
            float(0.5 * x @ (quadratic @ x) + linear @ x + constant),
            float(np.abs(x[self.a]).max()),
            float(np.abs(quadratic @ step).max()) / COST_SCALE,
            self._bend(x, bend, trajectory),
        )

    def _bend(self, x: Array, bend: Bend, trajectory: Trajectory) -> Bend:
        """True values at the end of a step less those of the rows without a bend."""
        state, lever = dynamics(self.problem, trajectory), self.problem.clear_lever
        slack, give = x[self.slack], x[self.give]
        linear = self.nominal.rotation[:, 2, :] @ lever.T
        linear += np.einsum("kpi,ki->kp", self._rise_by_turn(), x[self.a])
        return Bend(
            state.moment - (slack[:, :3] - slack[:, 3:]) + bend.moment,
            state.table - x[self.table] - (give[:, :3] - give[:, 3:]) + bend.table,
            trajectory.rotation[:, 2, :] @ lever.T - linear,
        )

    def _rise_by_turn(self) -> Array:
        """(K, P, 3) gradient of the height of Exp(a) R p: z + e_z . (a x R p)."""
        lever = np.einsum("kij,pj->kpi", self.nominal.rotation, self.problem.clear_lever)
        return np.stack((lever[..., 1], -lever[..., 0], np.zeros(lever.shape[:2])), axis=-1)

    def _point(self) -> Array:
        """The nominal trajectory as a vector of variables."""
        x = np.zeros(self.layout.size)
        x[self.omega], x[self.sigma] = self.nominal.omega, self.nominal.sigma
        x[self.table], x[self.push] = self.state.table, self.nominal.local
        return x

    def _cost(self) -> tuple[Any, Array, float]:
        """Gauss-Newton model 0.5 x' P x + q' x + c of the scaled cost with the penalty."""
        problem, layout = self.problem, self.layout
        weights, h = COST_SCALE * problem.weights.as_array, problem.step_s
        blocks: list[tuple[Any, Array, Array]] = []  # columns, J, r: cost |J x + r|^2
        last = Rotation.from_matrix(self.nominal.rotation[-1])
        error = (last * Rotation.from_quat(problem.orientation).inv()).as_quat(canonical=True)
        jacobian = np.sqrt(weights[0]) * (error[3] * np.eye(3) - skew(error[:3]))
        blocks.append((self.a[-1:], jacobian[None], np.sqrt(weights[0]) * 2.0 * error[None, :3]))
        scale = np.sqrt(weights[1] * h)
        blocks.append((self.sigma, scale * np.eye(3)[None], np.zeros((1, 3))))
        scale = np.sqrt(weights[2] * h)
        rho, by_table = slope(self.state.table)
        offset = rho - np.einsum("kij,kj->ki", by_table, self.state.table)
        blocks.append((self.table, scale * by_table, scale * offset))
        for finger in range(layout.fingers):
            force = self.nominal.local[:, finger]
            keep = slice(None, -1) if finger == layout.fingers - 1 else slice(None)
            rho, by_force = slope(force[keep])
            offset = rho - np.einsum("kij,kj->ki", by_force, force[keep])
            blocks.append((self.push[keep, finger], scale * by_force, scale * offset))
        quadratic, linear = Rows(layout.size), np.zeros(layout.size)
        quadratic.count, constant = layout.size, 0.0
        for columns, jac, residual in blocks:
            quadratic.put(columns, columns, 2.0 * np.swapaxes(jac, -1, -2) @ jac)
            pull = 2.0 * np.einsum("...ij,...i->...j", jac, residual)
            np.add.at(linear, columns, np.broadcast_to(pull, columns.shape))
            constant += float(np.sum(residual**2))
        linear[self.slack], linear[self.give] = PENALTY, FORCE * PENALTY
        return quadratic.matrix(), linear, constant

    def _equalities(self, rows: Rows, bend: Bend) -> int:
        problem, nominal, h = self.problem, self.nominal, self.problem.step_s
        eye, steps = np.eye(3), problem.steps
        ends = rows.open(np.zeros((4, 3)))
        places = np.stack((self.a[0], self.omega[0], self.omega[-1], self.sigma[-1]))
        rows.put(ends, places, eye)
        turn = h * nominal.omega[:-1]
        forward = Rotation.from_rotvec(turn).as_matrix()
        lean = h * left_jacobian(turn)
        row = rows.open(-np.einsum("kij,kj->ki", lean, nominal.omega[:-1]))
        rows.put(row, self.a[1:], eye)
        rows.put(row, self.a[:-1], -forward)
        rows.put(row, self.omega[:-1], -lean)
        row = rows.open(np.zeros((steps - 1, 3)))
        rows.put(row, self.omega[1:], eye)
        rows.put(row, self.omega[:-1], -eye)
        rows.put(row, self.sigma[:-1], -h * eye)
        state = self.state
        moment, table = state.moment + bend.moment, state.table + bend.table
        row = self._linear_dynamics(rows, moment, state.moment_by, 10.0)
        rows.put(row, self.slack, 10.0 * np.hstack((-eye, eye)))
        row = self._linear_dynamics(rows, table, state.table_by, 1.0)
        rows.put(row, self.table, -eye)
        rows.put(row, self.give, np.hstack((-eye, eye)))
        ramp = rows.open(problem.ramp[1:, None])
        rows.put(ramp, self.push[:, -1, 2:], np.ones((1, 1)))
        gone = rows.open(np.zeros(2))
        rows.put(gone[None], self.push[-1:, -1, :2], np.eye(2))
        return rows.count

    def _linear_dynamics(
        self, rows: Rows, value: Array, by: tuple[Array, ...], scale: float
    ) -> NDArray[np.intp]:
        """Rows of scale (value + sum of derivatives times changes) = ...; returns their numbers."""
        nominal = self.nominal
        local = nominal.local.reshape(self.problem.steps, -1)
        known = (
            np.einsum("kij,kj->ki", by[1], nominal.omega)
            + np.einsum("kij,kj->ki", by[2], nominal.sigma)
            + np.einsum("kij,kj->ki", by[3], local)
        )
        row = rows.open(scale * (known - value))
        push = self.push.reshape(self.problem.steps, -1)
        for columns, block in zip((self.a, self.omega, self.sigma, push), by, strict=True):
            rows.put(row, columns, scale * block)
        return row

    def _inequalities(self, rows: Rows, bend: Bend) -> int:
        problem, first, one = self.problem, rows.count, np.ones((1, 1))
        normals = [self.table[:, 2:], *(self.push[:, i, 2:] for i in range(problem.staying))]
        for i, columns in enumerate(normals):
            lower = problem.normal_min[i] + BOUND_RESERVE_N
            upper = problem.normal_max[i] - BOUND_RESERVE_N
            rows.put(rows.open(np.full((problem.steps, 1), -lower)), columns, -one)
            rows.put(rows.open(np.full((problem.steps, 1), upper)), columns, one)
        for positive in (self.slack, self.give):
            rows.put(rows.open(np.zeros(positive.shape)), positive, -np.eye(6))
        limit = np.full(self.a.shape, self.radius)
        rows.put(rows.open(limit), self.a, np.eye(3))
        rows.put(rows.open(limit), self.a, -np.eye(3))
        if len(problem.clear_rise):
            rise = self.nominal.rotation[:, 2, :] @ problem.clear_lever.T + bend.rise
            row = rows.open(rise - problem.clear_rise)
            rows.put(row, self.a, -self._rise_by_turn())
        return rows.count - first

    def _cones(self, rows: Rows) -> int:
        """Rows (mu f_n, f_x, f_y) in the second-order cone, contact by contact."""
        problem, steps = self.problem, self.problem.steps
        friction = problem.friction * (1.0 - FRICTION_RESERVE)
        contacts = [self.table, *(self.push[:, i] for i in range(problem.staying + 1))]
        count = 0
        for i, columns in enumerate(contacts):
            keep = steps - 1 if i == len(contacts) - 1 else steps
            row = rows.open(np.zeros((keep, 3)))
            pick = -np.array([[0.0, 0.0, friction[i]], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            rows.put(row, columns[:keep], pick)
            count += keep
        return count

    def _rates(self, rows: Rows) -> int:
        """Rows (limit, f_k - f_k-1) in the second-order cone, in the contact frames."""
        problem, push = self.problem, self.push
        limit = problem.change_max * (1.0 - FRICTION_RESERVE)
        side = np.zeros((problem.steps, self.layout.fingers, 4))
        side[..., 0], side[0, :, 1:] = limit, -problem.start_local
        row = rows.open(side)[..., 1:]
        rows.put(row, push, -np.eye(3))
        rows.put(row[1:], push[:-1], np.eye(3))
        return int(row[..., 0].size)
