"""The readable reference: the problem as one would write it down, by CVXPY on Clarabel."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import grasp_map
from pivotgait.exceptions import SolverError
from pivotgait.forces import objectives
from pivotgait.forces.found import Found
from pivotgait.forces.local_form import local_form
from pivotgait.forces.problem import MARGIN_SLACK, AllocationProblem
from pivotgait.forces.proxqp_build import load_cvxpy

Array = NDArray[np.float64]
TIGHT = {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10}
"""As tight as the direct solver: a reference must not be the looser one."""
LOOSE = {"tol_feas": 1e-9, "tol_gap_abs": 1e-9, "tol_gap_rel": 1e-9}
"""Where the tight ones cannot be met: the sign of a shift that comes close to 0, thin sets."""
ROUNDS = 60


def solve(problem: AllocationProblem) -> Found:
    """Forces (T, m, 3), NaN where infeasible; feasible (T,); the most programs of a sample.

    Raises:
        SolverError: no answer and no proof that there is none.
    """
    if not (problem.coupled or problem.samples == 1):
        parts = [solve(problem.sample(k)) for k in range(problem.samples)]
        return Found.of(parts)
    solver = {"alignment": _alignment, "margin": _margin}.get(problem.objective, _convex)
    found, programs = solver(problem)
    shape = (problem.samples, problem.contacts, 3)
    feasible = np.full(problem.samples, found is not None)
    force = np.full(shape, np.nan) if found is None else found
    return Found(force, feasible, programs)


def constraints(problem: AllocationProblem, f: list[Any], friction: Array, shift: Any = 0.0) -> Any:
    """Every constraint of the problem on the CVXPY forces f[k] (m, 3).

    Args:
        problem: T samples.
        f: T variables.
        friction: (m,) friction of the cones.
        shift: (T, m) expression added to the cones' limits, or 0.
    """
    cp = load_cvxpy()

    grasp, out = grasp_map(problem.lever), []
    for k in range(problem.samples):
        stacked = cp.vec(f[k], order="C")
        normals = problem.normals[k]
        normal = cp.sum(cp.multiply(f[k], normals), axis=1)
        project = np.eye(3) - normals[:, :, None] * normals[:, None, :]
        out.append(grasp[k] @ stacked == problem.wrench[k])  # eq. 3
        for i in range(problem.contacts):
            if not problem.loaded[k, i]:
                out.append(f[k][i] == 0.0)
                continue
            extra = 0.0 if isinstance(shift, float) else shift[k, i]
            out.append(cp.norm(project[i] @ f[k][i]) <= friction[i] * normal[i] + extra)  # eq. 5
            out.append(normal[i] >= problem.normal_min[k, i])  # eq. 6
            if np.isfinite(problem.normal_max[k, i]):
                out.append(normal[i] <= problem.normal_max[k, i])
            if not np.isnan(problem.fixed[k, i]):
                out.append(normal[i] == problem.fixed[k, i])  # eqs 7, 8
        if problem.rows is not None:
            rows = problem.rows
            low, high = np.isfinite(rows.lower[k]), np.isfinite(rows.upper[k])
            out.append(rows.matrix[k][low] @ stacked >= rows.lower[k][low])
            out.append(rows.matrix[k][high] @ stacked <= rows.upper[k][high])
        if problem.force_rate_max is not None and problem.step_s is not None and k > 0:
            limit = problem.force_rate_max * problem.step_s
            out.append(cp.norm(f[k] - f[k - 1], axis=1) <= limit)
    if problem.start is not None:
        out.append(f[0] == problem.start)
    if problem.end is not None:
        out.append(f[-1] == problem.end)
    return out


def _variables(problem: AllocationProblem) -> list[Any]:
    cp = load_cvxpy()

    return [cp.Variable((problem.contacts, 3)) for _ in range(problem.samples)]


def _run(goal: Any, rows: Any, f: list[Any], settings: dict[str, float] = TIGHT) -> Array | None:
    cp = load_cvxpy()

    program = cp.Problem(cp.Minimize(goal), rows)
    try:
        program.solve(solver=cp.CLARABEL, **settings)
    except cp.error.SolverError:
        try:
            program.solve(solver=cp.CLARABEL, **LOOSE)
        except cp.error.SolverError as error:
            raise SolverError(f"CVXPY: {error}", mend="use solver='interior_point'") from error
    if "infeasible" in program.status:
        return None
    return np.stack([variable.value for variable in f])


def _tangential(problem: AllocationProblem, f: list[Any]) -> Any:
    cp = load_cvxpy()

    total = 0.0
    for k, i in np.argwhere(problem.loaded):
        n = problem.normals[k, i]
        tangent = (np.eye(3) - np.outer(n, n)) @ f[k][i]
        total = total + cp.quad_over_lin(tangent, n @ f[k][i])
    return total


def _effort(problem: AllocationProblem, f: list[Any]) -> Any:
    cp = load_cvxpy()

    return sum(cp.sum_squares(variable) for variable in f)


def _convex(problem: AllocationProblem) -> tuple[Array | None, int]:
    f = _variables(problem)
    goal = (_effort if problem.objective == "effort" else _tangential)(problem, f)
    return _run(goal, constraints(problem, f, problem.friction), f), 1


def _alignment(problem: AllocationProblem) -> tuple[Array | None, int]:
    """Successive convex programs on the convex part of the curvature, with a line search."""
    cp = load_cvxpy()

    force, programs = _convex(replace(problem, objective="tangential"))
    if force is None:
        return None, programs
    frames, loaded = local_form(problem).frames, problem.loaded
    back = np.swapaxes(frames, -1, -2)

    def total(force: Array) -> float:
        x = (back @ force[..., None])[..., 0]
        return float(objectives.value("alignment", x[loaded].T).sum())

    while programs < ROUNDS:
        x = (back @ force[..., None])[..., 0]
        f, goal, slope = _variables(problem), 0.0, np.zeros(force.shape)
        for k, i in np.argwhere(loaded):
            rotation = frames[k, i]
            slope[k, i] = rotation @ objectives.gradient("alignment", x[k, i])
            curvature = objectives.hessian("alignment", x[k, i])
            weight, axes = np.linalg.eigh(curvature)
            root = (np.sqrt(np.maximum(weight, 0.0)) * axes).T @ rotation.T
            move = f[k][i] - force[k, i]
            goal = goal + slope[k, i] @ move + 0.5 * cp.sum_squares(root @ move)
        aim = _run(goal, constraints(problem, f, problem.friction), f)
        programs += 1
        if aim is None:
            raise SolverError("CVXPY lost a feasible allocation", mend="loosen its bounds")
        promise = -float(np.sum(slope * (aim - force)))
        if promise <= 1e-10 * loaded.sum():
            break
        length = 1.0
        while length > 1e-4 and total(force + length * (aim - force)) > total(force):
            length *= 0.5
        force = force + length * (aim - force)
    return force, programs


def _margin(problem: AllocationProblem) -> tuple[Array | None, int]:
    """Bisection on the largest |f_t| / (mu f_n), then ``tangential`` within it."""
    cp = load_cvxpy()

    force, _ = _convex(replace(problem, objective="tangential"))
    if force is None:
        return None, 1
    low, high, programs = 0.0, 1.0, 1
    while high - low > 1e-7:
        ratio = 0.5 * (low + high)
        f, shift = _variables(problem), cp.Variable()
        common = shift * np.ones((problem.samples, problem.contacts))
        rows = constraints(problem, f, ratio * problem.friction, common)
        _run(shift, [*rows, shift >= -1.0], f, LOOSE)
        programs += 1
        low, high = (low, ratio) if shift.value <= 1e-9 else (ratio, high)
    f = _variables(problem)
    rows = constraints(problem, f, (high + MARGIN_SLACK) * problem.friction)
    return _run(_tangential(problem, f), rows, f), programs + 1
