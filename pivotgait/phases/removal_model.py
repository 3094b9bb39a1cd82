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
from dataclasses import dataclass, field
from typing import Any

INF = float("inf")


@dataclass
class StageProgram:
    """A discrete-time optimal control problem in CasADi symbols.

    Attributes:
        variables, constraints, parameters: of the nonlinear program.
        residuals: their sum of squares is the objective.
        concave: numbers of the constraint rows that are concave functions.
        lower, upper: bounds of the constraints.
        equality: which constraints are equalities.
        states, controls, path_rows: sizes per stage, as FATROP wants them.
    """

    parameters: Any
    variables: list[Any] = field(default_factory=list)
    residuals: list[Any] = field(default_factory=list)
    constraints: list[Any] = field(default_factory=list)
    concave: list[int] = field(default_factory=list)
    lower: list[float] = field(default_factory=list)
    upper: list[float] = field(default_factory=list)
    equality: list[bool] = field(default_factory=list)
    states: list[int] = field(default_factory=list)
    controls: list[int] = field(default_factory=list)
    path_rows: list[int] = field(default_factory=list)

    def equal(self, expression: Any) -> None:
        """Constrain an expression to 0."""
        self._append(expression, 0.0, True)

    def positive(self, expression: Any) -> None:
        """Constrain an expression to be at least 0."""
        self._append(expression, INF, False)

    def positive_concave(self, expression: Any) -> None:
        """Constrain a concave expression to be at least 0."""
        first = len(self.lower)
        self.positive(expression)
        self.concave += range(first, len(self.lower))

    def _append(self, expression: Any, upper: float, equality: bool) -> None:
        rows = expression.shape[0]
        self.constraints.append(expression)
        self.lower += [0.0] * rows
        self.upper += [upper] * rows
        self.equality += [equality] * rows


PARAMETERS: dict[str, Callable[[int, int], tuple[int, int]]] = {
    "orientation": lambda n, p: (4, 1),
    "step_s": lambda n, p: (1, 1),
    "mass": lambda n, p: (1, 1),
    "inertia": lambda n, p: (3, 3),
    "pivot_in_tool": lambda n, p: (3, 1),
    "gravity": lambda n, p: (3, 1),
    "points": lambda n, p: (3, n + 1),
    "frames": lambda n, p: (9, n + 1),
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


class Attitude:
    """Quaternion formulae (xyzw) in CasADi symbols."""

    @staticmethod
    def matrix(ca: Any, q: Any) -> Any:
        """Rotation matrix of a unit quaternion."""
        x, y, z, w = q[0], q[1], q[2], q[3]
        return ca.vertcat(
            ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            ca.horzcat(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            ca.horzcat(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )

    @staticmethod
    def product(ca: Any, a: Any, b: Any) -> Any:
        """Hamilton product a b."""
        return ca.vertcat(
            a[3] * b[:3] + b[3] * a[:3] + ca.cross(a[:3], b[:3]),
            a[3] * b[3] - ca.dot(a[:3], b[:3]),
        )

    @staticmethod
    def exponential(ca: Any, turn: Any) -> Any:
        """Quaternion of a rotation vector, as a series in its squared half angle y.

        Smooth at 0, where omega starts and ends; truncated at 2e-16 for y <= 0.04, that is for
        steps below 23 degrees, which :func:`pivotgait.phases.removal` checks.
        """
        y = ca.dot(turn, turn) / 4
        sinc = 1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110))))
        cosine = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90))))
        return ca.vertcat(sinc * turn / 2, cosine)


def removal_program(steps: int, staying: int, clear_points: int, *, rated: bool) -> StageProgram:
    """Build the program.

    Args:
        steps: K.
        staying: number of fingers that stay.
        clear_points: number of points kept over the table.
        rated: whether the rate of the finger forces is bounded.
    """
    import casadi as ca

    symbols = {
        name: ca.SX.sym(name, *shape(staying, clear_points)) for name, shape in PARAMETERS.items()
    }
    program = StageProgram(ca.vertcat(*[ca.vec(symbol) for symbol in symbols.values()]))
    states = [ca.SX.sym(f"x{k}", 7) for k in range(1, steps + 1)]
    stage = _Stage(ca, symbols, staying)
    before = stage.start()
    for k in range(1, steps + 1):
        state, last = states[k - 1], k == steps
        size = (0 if last else 3) + 3 * staying + (0 if last else 2) + 3
        control = ca.SX.sym(f"u{k}", size)
        program.variables += [state, control]
        program.states.append(7)
        program.controls.append(size)
        rates = ca.SX.zeros(3) if last else control[:3]
        fingers = stage.fingers(control[0 if last else 3 : -3], 1.0 - k / steps)
        if not last:
            program.equal(states[k] - stage.advance(state, rates))
        first = len(program.lower)
        if k == 1:
            start = ca.vertcat(symbols["orientation"], ca.SX.zeros(3))
            program.equal(state - start)
        if last:
            program.equal(state[4:])
            back = ca.vertcat(-symbols["orientation"][:3], symbols["orientation"][3])
            turn = Attitude.product(ca, back, state[:4])[:3]
            # its square is 4 sin^2(delta / 2) = 4 (1 - (r_0 . r_K)^2), but convex in r_K
            program.residuals.append(2 * ca.sqrt(symbols["weights"][0]) * turn)
        if rated:
            stage.limit_change(program, before, fingers)
            before = fingers
        contacts = [(control[-3:-1], control[-1]), *fingers]
        stage.constrain(program, state, rates, contacts)
        program.residuals.append(stage.residuals(rates, contacts))
        program.path_rows.append(len(program.lower) - first)
    return program


@dataclass
class _Stage:
    """The formulae of one stage."""

    ca: Any
    p: dict[str, Any]
    staying: int

    def start(self) -> list[Any]:
        """Forces of the fingers at k = 0 in their contact frames, as (tau, f_n)."""
        local = self.p["start_local"]
        return [(local[:2, i] / local[2, i], local[2, i]) for i in range(self.staying + 1)]

    def fingers(self, part: Any, share: float) -> list[Any]:
        """Split into (tau, f_n) per finger; the leaving one has ``share`` of its first f_n."""
        found = [(part[3 * i : 3 * i + 2], part[3 * i + 2]) for i in range(self.staying)]
        if share > 0.0:
            found.append((part[-2:], share * self.p["start_local"][2, -1]))
        return found

    def limit_change(self, program: StageProgram, now: list[Any], then: list[Any]) -> None:
        """Bound |f_k+1 - f_k| of each finger, in its contact frame."""
        ca = self.ca
        for i, (tau, normal) in enumerate(now):
            change = normal * ca.vertcat(tau, 1)
            if i < len(then):
                change -= then[i][1] * ca.vertcat(then[i][0], 1)
            program.positive(self.p["change_max"] ** 2 - ca.dot(change, change))

    def advance(self, state: Any, rates: Any) -> Any:
        """Next state by the Euler steps of Section IV-A, in body rates."""
        ca, h = self.ca, self.p["step_s"]
        turn = h * state[4:]
        back = Attitude.matrix(ca, Attitude.exponential(ca, -turn))
        return ca.vertcat(
            Attitude.product(ca, state[:4], Attitude.exponential(ca, turn)),
            state[4:] + h * back @ rates,
        )

    def constrain(self, program: StageProgram, state: Any, rates: Any, contacts: list[Any]) -> None:
        """Dynamics (3), cones (5), bounds (6) and clearance over the table."""
        ca, p = self.ca, self.p
        turn = Attitude.matrix(ca, state[:4])
        self._dynamics(program, turn, state[4:], rates, contacts)
        for i, (tau, _) in enumerate(contacts):
            program.positive_concave(p["friction"][i] ** 2 - ca.dot(tau, tau))
        for i in range(self.staying + 1):  # the ramp fixes the leaving finger's
            normal = contacts[i][1]
            program.positive(normal - p["normal_min"][i])
            program.positive(p["normal_max"][i] - normal)
        if p["clear_rise"].shape[0]:
            rise = p["clear_lever"].T @ turn[2, :].T
            program.positive(rise - p["clear_rise"])

    def _dynamics(
        self, program: StageProgram, turn: Any, omega: Any, rates: Any, contacts: list[Any]
    ) -> None:
        ca, p = self.ca, self.p
        arm = -p["pivot_in_tool"]  # from the pivot to the centre of mass
        mass, weight = p["mass"], p["mass"] * (turn.T @ p["gravity"])
        about_pivot = p["inertia"] + mass * (ca.dot(arm, arm) * ca.SX.eye(3) - arm @ arm.T)
        moment, push = ca.cross(arm, weight), weight
        for i, (tau, normal) in enumerate(contacts[1:]):
            frame = ca.reshape(p["frames"][:, i], 3, 3)
            force = normal * (frame @ ca.vertcat(tau, 1))
            moment += ca.cross(p["points"][:, i] + arm, force)
            push += force
        spin = about_pivot @ rates + ca.cross(omega, about_pivot @ omega)
        # a moment of 1 N m is about 10 N at the length of a handle: rows of like size
        program.equal(10.0 * (spin - moment))
        rate = ca.cross(rates, arm) + ca.cross(omega, ca.cross(omega, arm))
        tau, normal = contacts[0]
        program.equal(normal * ca.vertcat(tau, 1) - turn @ (mass * rate - push))

    def residuals(self, rates: Any, contacts: list[Any]) -> Any:
        """Square roots of the stage's cost h (w_a |s|^2 + w_n sum sin^2)."""
        ca, weights, h = self.ca, self.p["weights"], self.p["step_s"]
        sines = [tau / ca.sqrt(1 + ca.dot(tau, tau)) for tau, _ in contacts]
        return ca.vertcat(
            ca.sqrt(weights[1] * h) * rates, ca.sqrt(weights[2] * h) * ca.vertcat(*sines)
        )
