"""The allocated forces, with the checks that prove them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import cone_margin, friction_margin, grasp_map
from pivotgait.exceptions import InfeasibleError
from pivotgait.forces.found import Found
from pivotgait.forces.problem import AllocationProblem
from pivotgait.frozen import frozen

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Allocation:
    """Contact forces of an :class:`AllocationProblem`. An infeasible sample holds NaN.

    Attributes:
        problem: what was asked.
        force: (T, m, 3) forces on the tool [N], in the problem's frame.
        feasible: (T,) whether forces exist; coupled samples share one answer.
        objective: (T,) value of the problem's objective: the sum over loaded contacts of
            sin^2 (``alignment``), |f_t|^2 / f_n [N] (``tangential``), |f|^2 [N^2] (``effort``),
            or the smallest friction margin (``margin``).
        solver: the solver that found them.
        iterations: of its slowest sample.
        converged: whether every feasible sample reached its optimum. ``margin``, and ``alignment``
            with coupled rows, may end short of it; the forces hold all limits anyway.
    """

    problem: AllocationProblem
    force: Array
    feasible: Mask
    objective: Array
    solver: str
    iterations: int
    converged: bool

    @classmethod
    def of(cls, problem: AllocationProblem, found: Found, solver: str) -> Allocation:
        """Record forces with their objective; forces of unloaded contacts become exactly 0."""
        force = np.where(problem.loaded[..., None], found.force, 0.0)
        force[~found.feasible] = np.nan
        flags = np.array(found.feasible, dtype=bool)
        flags.setflags(write=False)
        value = frozen(_objective(problem, force))
        return cls(problem, frozen(force), flags, value, solver, found.iterations, found.converged)

    @property
    def normal_force(self) -> Array:
        """(T, m) normal components [N]."""
        return np.asarray(np.sum(self.force * self.problem.normals, axis=-1))

    def wrench_residual(self) -> tuple[Array, Array]:
        """(T,) force [N] and (T,) moment [N m] by which the wrench is missed (eq. 3)."""
        p = self.problem
        flat = self.force.reshape(p.samples, -1, 1)
        miss = (grasp_map(p.lever) @ flat)[..., 0] - p.wrench
        return np.linalg.norm(miss[:, :3], axis=1), np.linalg.norm(miss[:, 3:], axis=1)

    def cone_margin(self) -> Array:
        """(T, m) mu f_n - |f_t| [N], at least 0 inside the cone (eq. 5)."""
        return cone_margin(self.force, self.problem.normals, self.problem.friction)

    def friction_margin(self) -> Array:
        """(T, m) relative margin 1 - |f_t| / (mu f_n); NaN without load."""
        return friction_margin(self.force, self.problem.normals, self.problem.friction)

    def bound_violation(self) -> Array:
        """(T,) largest violation of bounds (eq. 6) and rows, in their units; 0 if none."""
        p = self.problem
        normal = self.normal_force
        low = np.where(p.loaded, p.normal_min - normal, 0.0)
        worst = np.maximum(low, normal - p.normal_max).max(axis=1)
        if p.rows is not None and p.rows.count:
            flat = self.force.reshape(p.samples, -1, 1)
            rows = (p.rows.matrix @ flat)[..., 0]
            beyond = np.maximum(p.rows.lower - rows, rows - p.rows.upper)
            worst = np.maximum(worst, beyond.max(axis=1))
        return np.asarray(np.maximum(worst, 0.0))

    def ramp_residual(self) -> Array:
        """(T,) largest |f_n - prescribed| [N] over the ramps (eqs 7, 8); 0 without ramps."""
        miss = np.abs(self.normal_force - self.problem.fixed)
        return np.asarray(np.where(np.isnan(self.problem.fixed), 0.0, miss).max(axis=1))

    def rate_violation(self) -> float:
        """Largest excess of |f_k - f_(k-1)| over rate * step [N]; 0 if none or no limit."""
        p = self.problem
        if p.force_rate_max is None or p.step_s is None or p.samples < 2:
            return 0.0
        jump = np.linalg.norm(np.diff(self.force, axis=0), axis=-1).max()
        return float(max(jump - p.force_rate_max * p.step_s, 0.0))

    def require(self) -> Allocation:
        """This allocation, if every sample is feasible.

        Raises:
            InfeasibleError: naming the sample, the contact and the limit that bind, and the
                smallest change that mends it.
        """
        if self.feasible.all():
            return self
        from pivotgait.forces.diagnosis import diagnose

        found = diagnose(self.problem, int(np.argmin(self.feasible)))
        share = f"{int((~self.feasible).sum())} of {self.problem.samples} samples"
        raise InfeasibleError(
            f"no contact forces for {share}; {found.text()}", mend=found.mend_text()
        )


def _objective(problem: AllocationProblem, force: Array) -> Array:
    normal = np.sum(force * problem.normals, axis=-1)
    square = np.sum(force**2, axis=-1)
    tangent = np.sum((force - normal[..., None] * problem.normals) ** 2, axis=-1)
    if problem.objective == "margin":
        margin = friction_margin(force, problem.normals, problem.friction)
        return np.asarray(np.where(problem.loaded, margin, np.inf).min(axis=1))
    if problem.objective == "effort":
        return np.asarray(square.sum(axis=1))
    below = normal if problem.objective == "tangential" else square
    below = np.where(problem.loaded, below, 1.0)
    return np.asarray(np.where(problem.loaded, tangent / below, 0.0).sum(axis=1))
