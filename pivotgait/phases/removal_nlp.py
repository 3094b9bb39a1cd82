"""Finger removal solved as one nonlinear program by FATROP or IPOPT (both through CasADi).

The compiled program depends only on the number of steps, fingers and clearance points; every
number of the problem is a parameter, so one program serves every cell of a sweep.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.contacts import grasp_map
from pivotgait.dynamics import required_wrench
from pivotgait.exceptions import SolverError
from pivotgait.phases.removal_model import removal_program
from pivotgait.phases.removal_packing import force_of, pack, places, slopes_of
from pivotgait.phases.removal_problem import RemovalProblem, RemovalSolution, removal_cost

Array = NDArray[np.float64]
NlpSolver = Literal["fatrop", "ipopt"]

SCALE_PER_STEP = 5.0
"""The objective is the cost times this and K. A good removal costs 1e-3 to 1e-1: scaled up, the
barrier that the solvers start with (0.1 for each constraint, whose number grows with K) does
not first drive the tool away from where it is."""
FLAT_STEPS = 128
"""Up to this K the whole program, as one list of operations, fits the processor's cache and is
a tenth faster than the mapped stages."""


class RemovalNlp:
    """A compiled removal program.

    Args:
        steps: K.
        staying: number of fingers that stay.
        clear_points: number of points kept over the table.
        solver: ``fatrop`` (uses the stage structure) or ``ipopt`` (general).
        warm: start the barrier low, for a guess that is nearly optimal.
        rated: bound the rate of finger forces, which couples stages: IPOPT only.
    """

    def __init__(
        self,
        steps: int,
        staying: int,
        clear_points: int,
        solver: NlpSolver,
        warm: bool,
        rated: bool,
    ) -> None:
        import casadi as ca

        scale = SCALE_PER_STEP * steps
        program = removal_program(steps, staying, clear_points, rated=rated, scale=scale)
        self.steps, self.staying, self.solver = steps, staying, solver
        self.scale, self.equality = scale, np.array(program.nlp.equality)
        self._bounds: dict[str, Any] = {"lbg": 0.0, "ubg": ca.DM(program.nlp.upper)}
        options: dict[str, Any] = {"print_time": False, "error_on_fail": False}
        flat = steps <= FLAT_STEPS

        def ready(function: Any) -> Any:
            return function.expand() if flat else function

        options["expand"] = flat
        if solver == "fatrop":
            options |= program.structure | {
                "cache": {
                    "nlp_grad_f": ready(program.nlp.ascent),
                    "nlp_jac_g": ready(program.nlp.slopes),
                    "nlp_hess_l": ready(program.nlp.curvature),
                },
                "fatrop.print_level": 0,
                # of the scaled problem: below it FATROP often stalls at the level of rounding
                "fatrop.tol": 1e-7,
                "fatrop.max_iter": 150,
            }
            if warm:
                options["fatrop.mu_init"] = 1e-5
        else:
            options |= {
                "ipopt.print_level": 0,
                "ipopt.sb": "yes",
                "ipopt.tol": 1e-8,
                "ipopt.constr_viol_tol": 1e-9,
                "ipopt.max_iter": 500,
                "jac_g": ready(program.nlp.slopes),
                "hess_lag": ready(program.nlp.upper_curvature(ca)),
            }
            if warm:
                options |= {"ipopt.warm_start_init_point": "yes", "ipopt.mu_init": 1e-5}
        self.nlpsol = ca.nlpsol("removal", solver, program.nlp.symbols, options)
        self._gradient = self.nlpsol.get_function("nlp_grad")
        self._places = places(program.states, program.controls, staying)

    def solve(self, problem: RemovalProblem, guess: RemovalSolution | None) -> RemovalSolution:
        """Solve one problem of this shape.

        Raises:
            SolverError: the solver did not converge.
        """
        parameters = pack(problem)
        start: dict[str, Any] = {"x0": self.guess(problem, guess)}
        multipliers = None if guess is None else guess.multipliers
        if multipliers is not None and len(multipliers) == len(self.equality):
            start["lam_g0"] = multipliers
        answer = self.nlpsol(p=parameters, **start, **self._bounds)
        stats = self.nlpsol.stats()
        x, dual = np.array(answer["x"]).ravel(), np.array(answer["lam_g"]).ravel()
        residual = self._kkt_residual(x, parameters, dual)
        # FATROP may stop a little short of its tolerance in the dual and call it a failure
        if not (stats["success"] or residual <= 1e-6):
            status = str(stats.get("unified_return_status", stats.get("return_status")))
            raise SolverError(
                f"{self.solver} found no removal in {stats.get('iter_count')} iterations "
                f"({status}, KKT residual {residual:.1e})",
                where="removal",
                mend="give more time or steps, more friction, or a smaller starting force",
            )
        return self._solution(problem, x, dual, residual, int(stats["iter_count"]))

    def _kkt_residual(self, x: Array, parameters: Array, dual: Array) -> float:
        """Largest violation of stationarity, feasibility, sign and complementarity."""
        _, rows, gradient, _ = self._gradient(x, parameters, 1.0, dual)
        g = np.array(rows).ravel()
        slack, pressure = g[~self.equality], dual[~self.equality]
        parts = [
            np.abs(np.array(gradient)).max() / self.scale,
            np.abs(g[self.equality]).max(),
            np.max(-slack, initial=0.0),
            np.max(pressure, initial=0.0) / self.scale,
            np.abs(slack * pressure).max(initial=0.0) / self.scale,
        ]
        return float(max(parts))

    def guess(self, problem: RemovalProblem, guess: RemovalSolution | None) -> Array:
        """Variables to start from: those of a solution, or the tool staying as it is."""
        x = np.zeros(self._places["size"])
        if guess is None:  # the tool stays where it is, and so do the forces of the others
            turn = Rotation.from_quat(problem.orientation).as_matrix()
            world = np.concatenate((np.eye(3)[None], turn @ problem.frames))
            local = np.einsum("mij,mi->mj", world, problem.start_force)
            normal = np.clip(local[:, 2], problem.normal_min, problem.normal_max)
            start = np.column_stack((slopes_of(local), normal))
            x[self._places["attitude"]] = problem.orientation
            x[self._places["table"]] = start[0]
            x[self._places["fingers"]] = start[1:-1].ravel()
            x[self._places["leaving"]] = start[-1, :2]
            return x
        turn = Rotation.from_quat(guess.orientation[1:]).as_matrix()
        orientation = guess.orientation[1:]
        signs = np.sign(orientation @ problem.orientation)[:, None]
        x[self._places["attitude"]] = orientation * np.where(signs == 0.0, 1.0, signs)
        x[self._places["omega"]] = np.einsum("kji,kj->ki", turn, guess.angular_velocity[1:])
        rates = np.einsum("kji,kj->ki", turn, guess.angular_acceleration[1:])
        x[self._places["s"]] = rates[:-1]
        frames = np.einsum("kij,mjl->kmil", turn, problem.frames)
        local = np.einsum("kmil,kmi->kml", frames, guess.force[1:, 1:])
        table = guess.force[1:, 0]
        x[self._places["table"]] = np.column_stack((slopes_of(table), table[:, 2]))
        for i in range(self.staying):
            columns = np.column_stack((slopes_of(local[:, i]), local[:, i, 2]))
            x[self._places["fingers"][:, 3 * i : 3 * i + 3]] = columns
        x[self._places["leaving"]] = slopes_of(local[:-1, -1])
        return x

    def _solution(
        self, problem: RemovalProblem, x: Array, dual: Array, residual: float, iterations: int
    ) -> RemovalSolution:
        place, samples, n = self._places, self.steps + 1, self.staying
        orientation = np.empty((samples, 4))
        orientation[0], orientation[1:] = problem.orientation, x[place["attitude"]]
        orientation /= np.linalg.norm(orientation, axis=1, keepdims=True)
        turn = Rotation.from_quat(orientation).as_matrix()
        omega, sigma = np.zeros((samples, 3)), np.zeros((samples, 3))
        omega[1:] = np.einsum("kij,kj->ki", turn[1:], x[place["omega"]])
        omega[-1] = 0.0
        sigma[1:-1] = np.einsum("kij,kj->ki", turn[1:-1], x[place["s"]])
        local = np.zeros((samples, n + 1, 3))
        for i in range(n):
            local[1:, i] = force_of(x[place["fingers"][:, 3 * i : 3 * i + 3]])
        ramp = problem.ramp
        local[1:-1, n] = force_of(np.column_stack((x[place["leaving"]], ramp[1:-1])))
        force = np.empty((samples, n + 2, 3))
        force[:, 1:] = np.einsum("kij,mjl,kml->kmi", turn, problem.frames, local, optimize=True)
        force[1:, 0] = force_of(x[place["table"]])
        force[0] = problem.start_force
        balance(problem, orientation, omega, sigma, force)
        return RemovalSolution(
            orientation=orientation,
            angular_velocity=omega,
            angular_acceleration=sigma,
            force=force,
            cost=removal_cost(problem, orientation, sigma, force),
            solver=self.solver,
            iterations=iterations,
            kkt_residual=residual,
            multipliers=dual,
        )


@lru_cache(maxsize=24)
def removal_nlp(
    steps: int,
    staying: int,
    clear_points: int,
    solver: NlpSolver = "fatrop",
    warm: bool = False,
    rated: bool = False,
) -> RemovalNlp:
    """The compiled program of a shape, built on first use (about 0.4 s at K = 64)."""
    return RemovalNlp(steps, staying, clear_points, solver, warm, rated)


def solve_removal(
    problem: RemovalProblem,
    *,
    solver: NlpSolver = "fatrop",
    guess: RemovalSolution | None = None,
) -> RemovalSolution:
    """Solve the removal problem of Section IV-A to local optimality.

    Args:
        problem: the numbers.
        solver: ``fatrop`` or ``ipopt``.
        guess: a solution of a like problem with the same number of steps.

    Raises:
        SolverError: the solver did not converge, or cannot bound the rate of forces.
    """
    if problem.rated and solver == "fatrop":
        raise SolverError(
            "fatrop cannot bound the rate of forces, which couples stages",
            where="removal",
            mend="use ipopt or socp, or no force_rate_max",
        )
    shape = (problem.steps, problem.staying, len(problem.clear_rise))
    warm = guess is not None and guess.multipliers is not None
    return removal_nlp(*shape, solver, warm, problem.rated).solve(problem, guess)


def balance(
    problem: RemovalProblem, orientation: Array, omega: Array, sigma: Array, force: Array
) -> None:
    """Remove the solver's residual of (3), about 1e-9 N, by the smallest change of forces.

    In place, samples 1..K; the leaving finger keeps its ramp. The reserves of :func:`pack` are
    larger than the change.
    """
    solution = RemovalSolution(orientation, omega, sigma, force, 0.0, "", 0, 0.0)
    motion = solution.motion(problem.body)
    levers = np.vstack((problem.body.pivot_in_tool, problem.points))
    g = grasp_map(np.einsum("kij,mj->kmi", motion.rotation.as_matrix(), levers))
    wrench = required_wrench(problem.body, motion)
    samples, contacts = force.shape[:2]
    missing = wrench - np.einsum("kij,kj->ki", g, force.reshape(samples, -1))
    kept = g[1:, :, : 3 * (contacts - 1)]
    if problem.staying >= 2:
        gram = kept @ np.swapaxes(kept, 1, 2)
        pull = np.linalg.solve(gram, missing[1:, :, None])
        change = np.swapaxes(kept, 1, 2) @ pull
    else:  # two points leave one moment free: the grasp map has rank five
        change = np.linalg.pinv(kept, rcond=1e-9) @ missing[1:, :, None]
    force[1:, :-1] += change.reshape(samples - 1, contacts - 1, 3)
