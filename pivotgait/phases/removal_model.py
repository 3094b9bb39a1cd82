"""The removal problem as a stage-structured nonlinear program in CasADi, built once per shape.

Fingers push in the tool frame and the table in the world, so that cones, bounds and the ramp
(7) carry constant data and only the table's force turns. Every contact force is written
f = f_n (tau_x, tau_y, 1): the exact cone (5) becomes |tau|^2 <= mu^2, also where the leaving
finger's f_n tends to 0, and sin^2 of its angle to the normal |tau|^2 / (1 + |tau|^2). Moments
are taken about the pivot, where the table has none.

Stage k = 1..K (k = 0 is given, and sigma_0 = omega_0 = 0 make r_1 = r_0, omega_1 = 0):
state x = (r, Omega), control u = (s, staying fingers, leaving finger, table) with the body
rates Omega = R' omega and s = R' sigma; the Euler steps of Section IV-A then read
r+ = r exp(h Omega), Omega+ = Omega + h Exp(-h Omega) s.

Eq. (4) is not convex, and its best forces may jump from one sample to the next. Rows that bound
the rate of the finger forces tie the controls of neighbouring stages together: a general solver
takes them, FATROP does not. (With the forces carried in the state, FATROP stalled on most
instances, its reduced Hessian being reported indefinite from stage to stage.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.phases.attitude import Attitude
from pivotgait.phases.stagewise import Piece, Program, assemble

Index = NDArray[np.intp]
STATE = 7
"""Size of the state (r, Omega)."""

PARAMETERS: dict[str, Callable[[int, int], tuple[int, int]]] = {
    "orientation": lambda n, p: (4, 1),
    "step_s": lambda n, p: (1, 1),
    "mass": lambda n, p: (1, 1),
    "weight": lambda n, p: (3, 1),  # m g, world
    "arm": lambda n, p: (3, 1),  # from the pivot to the centre of mass
    "about_pivot": lambda n, p: (3, 3),  # inertia
    "frames": lambda n, p: (9, n + 1),  # contact frames
    "moments": lambda n, p: (9, n + 1),  # [lever]x times contact frames
    "friction": lambda n, p: (n + 2, 1),
    "normal_min": lambda n, p: (n + 2, 1),
    "normal_max": lambda n, p: (n + 2, 1),
    "start_local": lambda n, p: (3, n + 1),
    "change_max": lambda n, p: (1, 1),
    "clear_lever": lambda n, p: (3, p),
    "clear_rise": lambda n, p: (p, 1),
    "weights": lambda n, p: (3, 1),
}
"""Parameters of the program in their order, with their shapes for n staying fingers, p points."""


@dataclass(frozen=True)
class RemovalProgram:
    """The nonlinear program, and its sizes by stage as FATROP wants them."""

    nlp: Program
    states: list[int]
    controls: list[int]
    path_rows: list[int]

    @property
    def structure(self) -> dict[str, Any]:
        """The stages, as options of ``casadi.nlpsol`` for FATROP."""
        return {
            "structure_detection": "manual",
            "N": len(self.states) - 1,
            "nx": self.states,
            "nu": self.controls,
            "ng": self.path_rows,
            "equality": self.nlp.equality,
        }


def removal_program(
    steps: int, staying: int, clear_points: int, *, rated: bool, scale: float
) -> RemovalProgram:
    """Build the program.

    Variables are (x_k, u_k) stage by stage. Constraints are, stage by stage, the flow to the
    next one, in the first stage its start, in the last its rest, then dynamics, cones, bounds
    and clearance; after all stages the rates of the finger forces.

    Args:
        steps: K.
        staying: number of fingers that stay.
        clear_points: number of points kept over the table.
        rated: whether the rate of the finger forces is bounded.
        scale: factor of the cost.
    """
    import casadi as ca

    stage, many = _Stage(ca, staying, clear_points), steps - 1
    width, width_last = STATE + 3 * staying + 8, STATE + 3 * staying + 3
    left, share = width * np.arange(steps), 1.0 - np.arange(1, steps + 1) / steps
    inner, last = stage.expressions(last=False), stage.expressions(last=True)
    rows = inner.rows.shape[0]
    # the start's rows stand between the first flow and the rest of the first stage
    places = STATE + rows * np.arange(many)[:, None] + np.arange(rows)
    places[0, :STATE] -= STATE
    end = STATE + rows * many
    pieces = [
        Piece(
            ca,
            inner.inputs,
            inner.rows,
            inner.cost,
            columns=left[:many, None] + np.arange(width),
            places=places,
            shares=share[:many, None],
        ),
        Piece(
            ca,
            last.inputs,
            last.rows,
            last.cost,
            columns=left[many:, None] + np.arange(width_last),
            places=end + np.arange(last.rows.shape[0])[None],
            shares=share[many:, None],
        ),
    ]
    equality = [True] * STATE + ([True] * inner.equal + [False] * (rows - inner.equal)) * many
    equality += [True] * last.equal + [False] * (last.rows.shape[0] - last.equal)
    if rated:
        pieces += stage.rates(left, share, len(equality))
        equality += [False] * (steps * (staying + 1))
    state = np.arange(STATE)
    ones = (  # x_k+1 in the flows, x_1 in the start
        np.concatenate((places[:, :STATE].ravel(), STATE + state)),
        np.concatenate(((left[1:, None] + state).ravel(), state)),
    )
    return RemovalProgram(
        nlp=assemble(
            ca,
            (width * many + width_last, len(equality), stage.parameters.shape[0]),
            pieces,
            ones,
            stage.offset(len(equality)),
            scale=scale,
            equality=equality,
        ),
        states=[STATE] * steps,
        controls=[width - STATE] * many + [width_last - STATE],
        path_rows=[rows] + [rows - STATE] * (many - 1) + [last.rows.shape[0]],
    )


@dataclass(frozen=True)
class _Expressions:
    """Rows (``equal`` equations first) and cost of one stage, of ``inputs`` (w, share, p)."""

    inputs: list[Any]
    rows: Any
    cost: Any
    equal: int


class _Stage:
    """The formulae of one stage, over one vector of parameters."""

    def __init__(self, ca: Any, staying: int, clear_points: int) -> None:
        self.ca, self.staying = ca, staying
        shapes = {name: shape(staying, clear_points) for name, shape in PARAMETERS.items()}
        self.p = {name: ca.SX.sym(name, *shape) for name, shape in shapes.items()}
        self.parameters = ca.vertcat(*[ca.vec(symbol) for symbol in self.p.values()])

    def expressions(self, *, last: bool) -> _Expressions:
        """Rows and cost: minus the next state (in the last stage the rates, to rest), ..."""
        ca = self.ca
        x, share = ca.SX.sym("x", STATE), ca.SX.sym("share")
        u = ca.SX.sym("u", 3 * self.staying + (3 if last else 8))
        rates = ca.SX.zeros(3) if last else u[:3]
        fingers = self.fingers(u[:-3] if last else u[3:-3], share, last=last)
        contacts = [(u[-3:-1], u[-1]), *fingers]
        turn = Attitude.matrix(ca, x[:4])
        equations = self.dynamics(turn, x[4:], rates, contacts)
        flow = x[4:] if last else -self.advance(x, rates)
        cost = self.cost(rates, contacts)
        return _Expressions(
            inputs=[ca.vertcat(x, u), share, self.parameters],
            rows=ca.cse(ca.vertcat(flow, equations, self.bounds(turn, contacts))),
            cost=cost + self.turn(x[:4]) if last else cost,
            equal=flow.shape[0] + equations.shape[0],
        )

    def offset(self, rows: int) -> Any:
        """Function of the parameters: the start's place (r_0, 0) in a vector of constraints."""
        ca = self.ca
        start = ca.vertcat(ca.SX.zeros(STATE), self.p["orientation"], ca.SX.zeros(rows - STATE - 4))
        return ca.Function("offset", [self.parameters], [start])

    def turn(self, orientation: Any) -> Any:
        """Cost of the reorientation, w_r 4 sin^2(delta / 2) = w_r 4 (1 - (r_0 . r_K)^2).

        Written as a sum of squares linear in r_K, it is convex.
        """
        ca, start = self.ca, self.p["orientation"]
        between = Attitude.product(ca, ca.vertcat(-start[:3], start[3]), orientation)[:3]
        return 4 * self.p["weights"][0] * ca.dot(between, between)

    def rates(self, left: Index, share: NDArray[np.float64], first_row: int) -> list[Piece]:
        """Bounds of |f_k+1 - f_k| of each finger in its contact frame, from k = 0."""
        ca, n = self.ca, self.staying
        many, held = len(left) - 1, 3 * n
        shares, rows = ca.SX.sym("share", 2), n + 1
        now, then = ca.SX.sym("now", held + 2), ca.SX.sym("then", held + 2)
        gone = ca.vertcat(then[:held], 0, 0)
        before = self._forces(now, shares[0])
        fingers = left[:many, None] + STATE + 3 + np.arange(held + 2)
        end = left[many:, None] + STATE + np.arange(held)
        pairs = np.column_stack((share[:-1], share[1:]))
        start = [self.p["start_local"][:, i] for i in range(rows)]
        jobs = [  # variables, forces before and after, columns, shares
            (then, start, self._forces(then, shares[1]), fingers[:1], np.array([[1.0, share[0]]])),
            (
                ca.vertcat(now, then),
                before,
                self._forces(then, shares[1]),
                np.hstack((fingers[:-1], fingers[1:])),
                pairs[:-1],
            ),
            (
                ca.vertcat(now, then[:held]),
                before,
                self._forces(gone, shares[1]),
                np.hstack((fingers[-1:], end)),
                pairs[-1:],
            ),
        ]
        pieces, row = [], first_row
        for w, old, new, columns, values in jobs:
            changes = [a - b for a, b in zip(new, old, strict=True)]
            kept = [self.p["change_max"] ** 2 - ca.dot(change, change) for change in changes]
            places = row + np.arange(len(columns) * rows).reshape(-1, rows)
            row += places.size
            inputs = [w, shares, self.parameters]
            cost = ca.SX.zeros(1)
            pieces.append(
                Piece(
                    ca,
                    inputs,
                    ca.vertcat(*kept),
                    cost,
                    columns=columns,
                    places=places,
                    shares=values,
                )
            )
        return pieces

    def _forces(self, part: Any, share: Any) -> list[Any]:
        contacts = self.fingers(part, share, last=False)
        return [normal * self.ca.vertcat(tau, 1) for tau, normal in contacts]

    def fingers(self, part: Any, share: Any, *, last: bool) -> list[Any]:
        """Split into (tau, f_n) per finger; the leaving one has ``share`` of its first f_n."""
        found = [(part[3 * i : 3 * i + 2], part[3 * i + 2]) for i in range(self.staying)]
        if not last:
            found.append((part[-2:], share * self.p["start_local"][2, -1]))
        return found

    def advance(self, state: Any, rates: Any) -> Any:
        """Next state by the Euler steps of Section IV-A, in body rates."""
        ca, h = self.ca, self.p["step_s"]
        turn = h * state[4:]
        back = Attitude.matrix(ca, Attitude.exponential(ca, -turn))
        return ca.vertcat(
            Attitude.product(ca, state[:4], Attitude.exponential(ca, turn)),
            state[4:] + h * back @ rates,
        )

    def bounds(self, turn: Any, contacts: list[Any]) -> Any:
        """Cones (5), bounds (6) and clearance over the table, each at least 0."""
        ca, p = self.ca, self.p
        rows = [p["friction"][i] ** 2 - ca.dot(tau, tau) for i, (tau, _) in enumerate(contacts)]
        for i in range(self.staying + 1):  # the ramp fixes the leaving finger's
            normal = contacts[i][1]
            rows += [normal - p["normal_min"][i], p["normal_max"][i] - normal]
        return ca.vertcat(*rows, p["clear_lever"].T @ turn[2, :].T - p["clear_rise"])

    def dynamics(self, turn: Any, omega: Any, rates: Any, contacts: list[Any]) -> Any:
        """Residuals of (3): moment about the pivot, and force with the table's in the world."""
        ca, p = self.ca, self.p
        weight = turn.T @ p["weight"]
        moment, push = ca.cross(p["arm"], weight), weight
        for i, (tau, normal) in enumerate(contacts[1:]):
            ray = ca.vertcat(tau, 1)
            moment += normal * (ca.reshape(p["moments"][:, i], 3, 3) @ ray)
            push += normal * (ca.reshape(p["frames"][:, i], 3, 3) @ ray)
        spin = p["about_pivot"] @ rates + ca.cross(omega, p["about_pivot"] @ omega)
        rate = ca.cross(rates, p["arm"]) + ca.cross(omega, ca.cross(omega, p["arm"]))
        tau, normal = contacts[0]
        # a moment of 1 N m is about 10 N at the length of a handle: rows of like size
        return ca.vertcat(
            10.0 * (spin - moment), normal * ca.vertcat(tau, 1) - turn @ (p["mass"] * rate - push)
        )

    def cost(self, rates: Any, contacts: list[Any]) -> Any:
        """Running cost of the stage: h (w_a |s|^2 + w_n sum sin^2)."""
        ca, weights, h = self.ca, self.p["weights"], self.p["step_s"]
        slopes = [ca.dot(tau, tau) for tau, _ in contacts]
        sines = sum(slope / (1 + slope) for slope in slopes)
        return h * (weights[1] * ca.dot(rates, rates) + weights[2] * sines)
