"""Can the fingers that stay hold the tool at rest, and after how small a turn?

A removal ends at rest, without the leaving finger. It is possible only if some orientation near
the start admits forces of the others that satisfy (3) with omega = omega' = 0, (5) and (6); the
smallest such turn bounds the reorientation of any removal from below (the search for it is
local, from fifteen starts: a smaller one may be missed where 30 degrees and more are needed).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.phases.attitude import Attitude
from pivotgait.phases.removal_model import PARAMETERS
from pivotgait.phases.removal_packing import pack
from pivotgait.phases.removal_problem import RemovalProblem

Array = NDArray[np.float64]

TURN_STARTS_RAD = (0.35, 0.6)
"""Size of the turns from which the search starts: about each axis of the tool, and diagonally."""


@dataclass(frozen=True, eq=False)
class StaticTurn:
    """Answer of :func:`smallest_turn`.

    Attributes:
        feasible: whether an orientation was found at all.
        angle: of the smallest turn found [rad]; 0 if no turn is needed, NaN if infeasible.
        orientation: (4,) after it, unit quaternion xyzw, world <- tool.
        force: (n + 2, 3) forces there, world [N]; the leaving finger's is 0.
        reason: if infeasible, how near the best start came.
    """

    feasible: bool
    angle: float
    orientation: Array
    force: Array
    reason: str = ""


def smallest_turn(problem: RemovalProblem) -> StaticTurn:
    """The smallest turn from the start after which the staying fingers hold the tool at rest.

    A local method started from fifteen orientations: the start itself and turns about the tool's
    axes and diagonals. The best answer is returned.

    Args:
        problem: of the removal; its steps, ramp and weights play no role.
    """
    solver = _turn_program(problem.staying, len(problem.clear_rise))
    parameters = pack(problem)
    best: StaticTurn | None = None
    nearest = np.inf
    for turn in _starts():
        start = Rotation.from_quat(problem.orientation) * Rotation.from_rotvec(turn)
        answer = solver.solve(parameters, start.as_quat(), problem)
        nearest = min(nearest, answer[1])
        if answer[0] is not None and (best is None or answer[0].angle < best.angle):
            best = answer[0]
        if best is not None and best.angle < 1e-6:
            break
    if best is not None:
        return best
    nothing = np.full((problem.staying + 2, 3), np.nan)
    reason = f"nearest miss {nearest:.2g} N"
    return StaticTurn(False, float("nan"), problem.orientation, nothing, reason)


def _starts() -> list[Array]:
    turns = [np.zeros(3)]
    for axis in np.eye(3):
        turns += [TURN_STARTS_RAD[0] * axis, -TURN_STARTS_RAD[0] * axis]
    for signs in product((1.0, -1.0), repeat=3):
        turns.append(TURN_STARTS_RAD[1] * np.array(signs) / np.sqrt(3.0))
    return turns


@lru_cache(maxsize=8)
def _turn_program(staying: int, clear_points: int) -> _TurnProgram:
    return _TurnProgram(staying, clear_points)


class _TurnProgram:
    """min 4 sin^2(delta / 2) over orientation and static forces, solved by IPOPT."""

    def __init__(self, staying: int, clear_points: int) -> None:
        import casadi as ca

        p = {n: ca.SX.sym(n, *shape(staying, clear_points)) for n, shape in PARAMETERS.items()}
        q, table = ca.SX.sym("q", 4), ca.SX.sym("f0", 3)
        pushes = [ca.SX.sym(f"f{i}", 3) for i in range(1, staying + 1)]  # contact frames
        turn = Attitude.matrix(ca, q)
        weight = turn.T @ p["weight"]
        forces, moment = weight + turn.T @ table, ca.cross(p["arm"], weight)
        for i, push in enumerate(pushes):
            forces += ca.reshape(p["frames"][:, i], 3, 3) @ push
            moment += ca.reshape(p["moments"][:, i], 3, 3) @ push
        rows, lower, upper = [ca.dot(q, q) - 1, forces, 10.0 * moment], [0.0] * 7, [0.0] * 7
        for i, push in enumerate([table, *pushes]):
            cone = (p["friction"][i] * push[2]) ** 2 - push[0] ** 2 - push[1] ** 2
            rows += [cone, push[2] - p["normal_min"][i], p["normal_max"][i] - push[2]]
        rows.append(p["clear_lever"].T @ turn[2, :].T - p["clear_rise"])
        inequalities = 3 * (staying + 1) + clear_points
        lower, upper = lower + [0.0] * inequalities, upper + [np.inf] * inequalities
        inner = ca.dot(q, p["orientation"])
        nlp = {
            "x": ca.vertcat(q, table, *pushes),
            "f": 4 * (1 - inner**2),
            "g": ca.vertcat(*rows),
            "p": ca.vertcat(*[ca.vec(symbol) for symbol in p.values()]),
        }
        options: dict[str, Any] = {
            "print_time": False,
            "error_on_fail": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": 1e-9,
            "ipopt.constr_viol_tol": 1e-9,
            "ipopt.max_iter": 200,
        }
        self._staying = staying
        self._solver: Any = ca.nlpsol("turn", "ipopt", nlp, options)
        self._bounds = {"lbg": ca.DM(lower), "ubg": ca.DM(upper)}
        self._equalities = 7

    def solve(
        self, parameters: Array, orientation: Array, problem: RemovalProblem
    ) -> tuple[StaticTurn | None, float]:
        """Solve from one orientation; the second value is the remaining violation."""
        n = self._staying
        normals = np.minimum(problem.normal_min + 1.0, problem.normal_max)[: n + 1]
        start = np.concatenate([orientation, *([0.0, 0.0, normal] for normal in normals)])
        answer = self._solver(x0=start, p=parameters, **self._bounds)
        x, rows = np.array(answer["x"]).ravel(), np.array(answer["g"]).ravel()
        equal, slack = rows[: self._equalities], rows[self._equalities :]
        miss = max(np.abs(equal).max(), np.max(-slack, initial=0.0))
        if not self._solver.stats()["success"]:
            return None, float(miss)
        rotation = Rotation.from_quat(x[:4])
        angle = (Rotation.from_quat(problem.orientation).inv() * rotation).magnitude()
        local = x[4:].reshape(n + 1, 3)
        force = np.zeros((n + 2, 3))
        force[0] = local[0]
        turn = rotation.as_matrix()
        force[1 : n + 1] = np.einsum("ij,mjk,mk->mi", turn, problem.frames[:n], local[1:])
        return StaticTurn(True, float(angle), rotation.as_quat(), force), float(miss)
