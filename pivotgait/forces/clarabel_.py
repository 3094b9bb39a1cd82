"""Clarabel, called directly: exact cones, coupled rows, whole trajectories as one program."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import SolverError
from pivotgait.forces import objectives
from pivotgait.forces.conic_program import ConicProgram
from pivotgait.forces.found import Found
from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.problem import MARGIN_SLACK, AllocationProblem
from pivotgait.forces.single_sample import assemble, serves

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
TOLERANCE = 1e-10
"""Gap and feasibility asked for: plans are certified to 1e-8, four digits looser than this."""
ACCEPTED = 1e-8
"""Clarabel may stop short of that on thin problems; below this residual the answer is used."""
ROUNDS = 60
"""Successive programs for ``alignment``: a handful is usual, flat valleys take more."""
DECREASE = 1e-10
"""``alignment`` ends when a round promises less than this per loaded contact."""
STALLED = 1e-6
"""``alignment`` has converged if its last round promised less than this per loaded contact."""


def solve(problem: AllocationProblem) -> Found:
    """Forces and the most iterations of a sample.

    Raises:
        SolverError: Clarabel ended without an answer or a proof that there is none.
    """
    if serves(problem):
        return _solve_single(problem)
    if problem.coupled or problem.samples == 1:
        x, steps, converged = _solve_one(problem)
        feasible = np.full(problem.samples, x is not None)
        force = np.full((problem.samples, problem.contacts, 3), np.nan) if x is None else x
        return Found(force, feasible, steps, converged)
    return Found.of([solve(problem.sample(k)) for k in range(problem.samples)])


def _solve_single(problem: AllocationProblem) -> Found:
    form = local_form(problem)
    v, steps = optimum(*assemble(problem, form))
    if v is None:
        return Found(np.full(form.value.shape, np.nan), np.zeros(1, dtype=bool), steps)
    x, loaded = np.array(form.value), ~form.known.all(axis=-1)
    x[loaded] = v[: 3 * int(loaded.sum())].reshape(-1, 3)
    x = np.where(form.known, form.value, x)
    return Found(form.world(_onto_wrench(form, problem.wrench, x)), np.ones(1, dtype=bool), steps)


def _solve_one(problem: AllocationProblem) -> tuple[Array | None, int, bool]:
    program, converged = ConicProgram.of(problem), True
    if not program.given_fits():
        return None, 0, True
    if problem.objective == "margin":
        x, steps = _margin(program)
    elif problem.objective == "alignment":
        x, steps, converged = _alignment(program)
    else:
        program.add_rows()
        program.add_rate()
        x, steps = _convex(program, problem.objective)
    return None if x is None else program.form.world(x), steps, converged


def _convex(program: ConicProgram, objective: str) -> tuple[Array | None, int]:
    program.add_friction()
    if objective == "tangential":
        u = program.add_tangential()
        linear = np.zeros(program.free.size)
        linear[u] = 1.0
        return _run(program, _Compiled(program), None, linear)
    curvature = np.broadcast_to(2.0 * np.eye(3), (*program.form.value.shape, 3))
    return _run(program, _Compiled(program), curvature, np.zeros(program.free.size))


def _alignment(program: ConicProgram) -> tuple[Array | None, int, bool]:
    """Successive conic programs on the convex part of the curvature, with a line search.

    Where a contact's force may vanish its curvature has no bound, and Clarabel may fail.
    """
    first = replace(program.problem, objective="tangential")
    start = ConicProgram.of(first)
    start.add_rows()
    start.add_rate()
    x, steps = _convex(start, "tangential")
    if x is None:
        return None, steps, True
    program.add_rows()
    program.add_rate()
    program.add_friction()
    compiled = _Compiled(program)
    loaded = program.loaded
    count = max(int(loaded.sum()), 1)

    def total(x: Array) -> float:
        return float(objectives.value("alignment", x[loaded].T).sum())

    now, promise = total(x), np.inf
    for _ in range(ROUNDS):
        gradient, curvature = np.zeros(x.shape), np.zeros((*x.shape, 3))
        gradient[loaded] = objectives.gradient("alignment", x[loaded].T).T
        curvature[loaded] = objectives.hessian("alignment", x[loaded].T).T
        free = np.where(program.form.known, 0.0, x)
        linear = gradient - (curvature @ free[..., None])[..., 0]
        try:
            aim, used = _run(program, compiled, curvature, linear.reshape(-1))
        except SolverError:
            break  # x is feasible; whether it is optimal, the last promise tells
        steps += used
        if aim is None:
            raise SolverError("Clarabel lost a feasible allocation", mend="loosen its bounds")
        promise = -float(np.sum(gradient * (aim - x)))
        if promise <= DECREASE * count:
            break
        length = 1.0
        while length > 1e-4 and total(x + length * (aim - x)) > now - 1e-4 * length * promise:
            length *= 0.5
        x = x + length * (aim - x)
        now = total(x)
    return x, steps, bool(promise <= STALLED * count)


def _margin(program: ConicProgram) -> tuple[Array | None, int]:
    """Dinkelbach's method on the largest |f_t| / (mu f_n), then ``tangential`` within it."""
    problem = program.problem
    start = ConicProgram.of(replace(problem, objective="tangential"))
    start.add_rows()
    start.add_rate()
    x, steps = _convex(start, "tangential")
    if x is None:
        return None, steps
    judged = start.loaded & ~start.given[:, None]
    if not judged.any():
        return x, steps

    def worst(x: Array) -> float:
        tangent = np.hypot(x[..., 0], x[..., 1])
        limit = np.where(judged, problem.friction * np.maximum(x[..., 2], 1e-12), 1.0)
        return float(np.max(np.where(judged, tangent / limit, 0.0)))

    ratio = worst(x)
    for _ in range(ROUNDS):
        trial = ConicProgram.of(problem)
        trial.friction = ratio * problem.friction * np.ones(judged.shape)
        shift = trial.add_auxiliary(1)
        trial.add_rows()
        trial.add_rate()
        trial.add_friction(shift, problem.friction * np.maximum(x[..., 2], 1e-6))
        linear = np.zeros(trial.free.size)
        linear[shift] = 1.0
        aim, used = _run(trial, _Compiled(trial), None, linear)
        steps += used
        gain = 0.0 if aim is None else ratio - worst(aim)
        if aim is not None and gain > 0.0:
            x, ratio = aim, worst(aim)
        if gain <= 1e-3 * MARGIN_SLACK:
            break
    else:
        raise SolverError(f"the margin still grows after {ROUNDS} rounds")
    final = ConicProgram.of(problem)
    final.friction = (ratio + MARGIN_SLACK) * problem.friction * np.ones(judged.shape)
    final.add_rows()
    final.add_rate()
    best, used = _convex(final, "tangential")
    return (x if best is None else best), steps + used


class _Compiled:
    """A program as sparse matrices, ready for many objectives."""

    def __init__(self, program: ConicProgram) -> None:
        import clarabel

        free = program.free
        self.place = np.cumsum(free) - 1
        known = np.where(free, 0.0, np.append(program.form.value, np.zeros(program.auxiliary)))
        rows, columns, entries, sides = [], [], [], []
        cones: list[Any] = []
        offset = 0
        order = {"zero": 0, "nonnegative": 1, "cone": 2}
        for block in sorted(program.blocks, key=lambda b: (order[b.kind], b.size)):
            count = block.constant.size
            if count == 0:
                continue
            fixed = ~free[block.column]
            side = block.constant + np.bincount(
                block.row[fixed],
                weights=(block.entry * known[block.column])[fixed],
                minlength=count,
            )
            rows.append(block.row[~fixed] + offset)
            columns.append(self.place[block.column[~fixed]])
            entries.append(-block.entry[~fixed])
            sides.append(side)
            offset += count
            if block.kind == "zero":
                cones.append(clarabel.ZeroConeT(count))
            elif block.kind == "nonnegative":
                cones.append(clarabel.NonnegativeConeT(count))
            else:
                cones += [clarabel.SecondOrderConeT(block.size)] * (count // block.size)
        self.width = int(free.sum())
        self.matrix = _sparse(
            np.concatenate(rows),
            np.concatenate(columns),
            np.concatenate(entries),
            offset,
            self.width,
        )
        self.side = np.concatenate(sides)
        self.cones = cones


def _run(
    program: ConicProgram, compiled: _Compiled, curvature: Array | None, linear: Array
) -> tuple[Array | None, int]:
    """Contact coordinates (T, m, 3) of the program's optimum, or None if it has no point."""
    free = program.free
    known = program.form.known
    x = np.array(program.form.value)
    if compiled.width == 0:
        return (x if np.all(np.abs(compiled.side) < ACCEPTED) else None), 0
    if curvature is None:
        none = np.zeros(0, dtype=np.intp)
        quadratic = _sparse(none, none, np.zeros(0), compiled.width, compiled.width)
    else:
        place = compiled.place[: x.size].reshape(x.shape)
        both = np.triu(~known[..., :, None] & ~known[..., None, :])
        row = np.broadcast_to(place[..., :, None], both.shape)[both]
        column = np.broadcast_to(place[..., None, :], both.shape)[both]
        quadratic = _sparse(row, column, curvature[both], compiled.width, compiled.width)
    v, steps = optimum(quadratic, linear[free], compiled.matrix, compiled.side, compiled.cones)
    if v is None:
        return None, steps
    x[~known] = v[: int((~known).sum())]
    return _onto_wrench(program.form, program.problem.wrench, x), steps


def optimum(
    quadratic: Any, linear: Array, matrix: Any, side: Array, cones: list[Any]
) -> tuple[Array | None, int]:
    """Optimum of Clarabel's standard form, or None if it has no point, and the iterations."""
    import clarabel

    steps = 0
    for tolerance in (TOLERANCE, ACCEPTED):
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.presolve_enable = False
        settings.max_threads = 1
        settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = tolerance
        settings.tol_infeas_abs = settings.tol_infeas_rel = TOLERANCE
        answer = clarabel.DefaultSolver(quadratic, linear, matrix, side, cones, settings).solve()
        status, v = str(answer.status), np.asarray(answer.x)
        steps += int(answer.iterations)
        if "Infeasible" in status:
            return None, steps
        close = status in ("Solved", "AlmostSolved") or answer.r_prim < ACCEPTED
        if close and np.all(np.isfinite(v)):
            return v, steps
    raise SolverError(f"Clarabel ended with {status}", mend="use solver='interior_point'")


def _sparse(row: Index, column: Index, entry: Array, rows: int, columns: int) -> Any:
    """A CSC matrix of entries at distinct places; several times faster than by way of COO."""
    from scipy.sparse import csc_matrix

    order = np.argsort(column * rows + row)
    start = np.zeros(columns + 1, dtype=np.int32)
    np.cumsum(np.bincount(column, minlength=columns), out=start[1:])
    indices = row[order].astype(np.int32)
    return csc_matrix((entry[order], indices, start), shape=(rows, columns))


def _onto_wrench(form: LocalForm, wrench: Array, x: Array) -> Array:
    """The nearest forces that apply the wrench to rounding; moves them by the solver's residual."""
    flat = x.reshape(len(x), -1)
    miss = wrench - (form.grasp @ flat[..., None])[..., 0]
    grasp = form.grasp * ~form.known.reshape(len(x), 1, -1)
    back = np.swapaxes(grasp, 1, 2)
    # Normal equations suffice for a correction of 1e-10; the shift is for deficient grasps.
    square = grasp @ back + 1e-12 * np.eye(6)
    flat = flat + (back @ np.linalg.solve(square, miss[..., None]))[..., 0]
    return np.asarray(flat.reshape(x.shape))
