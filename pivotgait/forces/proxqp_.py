"""ProxQP (proxsuite, dense) on an inner pyramid of the cones: every answer obeys eq. (5).

ProxQP takes no cones, so its objective lies above that of the exact cones where friction binds.
The problem is posed in the null space of the equations, where its Hessian is regularised: the
directions of pure squeezing have no curvature, and ProxQP is slow without.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import inner_pyramid
from pivotgait.exceptions import InputError, SolverError
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.found import Found
from pivotgait.forces.goal import Goal
from pivotgait.forces.local_form import local_form
from pivotgait.forces.null_space import Inconsistent, Reduced, reduce
from pivotgait.forces.phase_one import phase_one
from pivotgait.forces.problem import AllocationProblem
from pivotgait.forces.proxqp_build import load_proxqp

Array = NDArray[np.float64]
FACETS = 8
EPS = 1e-9
"""Absolute residual and duality gap asked of ProxQP, on forces scaled to about one."""
INSET = 1e-8
"""Rows are drawn in by this, as ProxQP meets them to ``EPS`` only and cones must hold."""
REGULARISATION = 1e-7
"""Proximal weight of the successive programs; it moves a step, not the fixed point."""
ROUNDS = 100
DECREASE = 1e-9
SUPPORTED = ("alignment", "tangential", "effort")


def solve(problem: AllocationProblem) -> Found:
    """Forces (T, m, 3), NaN where the pyramid has no point; feasible (T,); the most programs.

    Raises:
        InputError: for a coupled problem or the objective ``margin``.
        SolverError: ProxQP ended without an answer.
    """
    if problem.coupled:
        raise InputError("ProxQP takes no force rate cones", mend="use solver='clarabel'")
    if problem.objective not in SUPPORTED:
        raise InputError(
            f"ProxQP does not serve objective {problem.objective!r}",
            mend=f"it serves {', '.join(SUPPORTED)}",
        )
    form = local_form(problem)
    x = np.full(form.value.shape, np.nan)
    friction = np.broadcast_to(problem.friction, (problem.samples, problem.contacts))
    most = 0
    for group in reduce(form, problem.wrench, friction):
        if isinstance(group, Inconsistent):
            continue
        for b, sample in enumerate(group.index):
            z, programs = _solve_one(group, b, problem.objective)
            most = max(most, programs)
            if z is not None:
                x[sample] = group.forces(np.tile(z[:, None], len(group.index)))[b]
    force = form.world(x)
    return Found(force, np.isfinite(x).all(axis=(1, 2)), most)


def _rows(cones: ConeBatch) -> tuple[Array, Array]:
    """Pyramid, bounds and linear rows of a batch of one as C z <= u."""
    matrix, offset, c = cones.matrix[..., 0], cones.offset[:, 0], cones.cones
    # Heads are already scaled by friction; slacks run over contacts first.
    facets = np.kron(inner_pyramid(1.0, FACETS), np.eye(c))
    sides = np.concatenate((facets @ matrix[: 3 * c], -matrix[3 * c :]))
    return sides, np.concatenate((-facets @ offset[: 3 * c], offset[3 * c :]))


def _solve_one(group: Reduced, b: int, objective: str) -> tuple[Array | None, int]:
    """Null-space point (d,), or None without one, and the programs it took."""
    cones = group.cones.take(np.array([b]))
    matrix, limit = _rows(cones)
    first = phase_one(ConeBatch(-matrix[..., None], limit[:, None], np.zeros((0, 1))))
    z = first.z[:, 0]
    if first.shift[0] > EPS:
        return None, 0
    if z.size == 0 or -first.shift[0] <= INSET:
        return z, 0
    goal = Goal(smooth=objective)

    def total(z: Array) -> float:
        return float(goal.value(cones, z[:, None], cones.slack(z[:, None]))[0])

    local = cones.matrix[: 3 * cones.cones, :, 0].reshape(3, cones.cones, -1)
    programs = 0
    while programs < ROUNDS:
        programs += 1
        s = cones.slack(z[:, None])
        slope = goal.slope(cones, s)[:, 0]
        curvature = np.einsum(
            "icd,ijc,jce->de", local, goal.curvature(cones, s, concave=0.0)[..., 0], local
        )
        aim = _program(curvature + REGULARISATION * np.eye(z.size), slope, matrix, limit, z)
        promise = -float(slope @ (aim - z))
        if promise <= DECREASE * max(total(z), 1e-3):
            break
        length, now = 1.0, total(z)
        while length > 1e-4 and total(z + length * (aim - z)) > now - 1e-4 * length * promise:
            length *= 0.5
        z = z + length * (aim - z)
    return z, programs


def _program(hessian: Array, slope: Array, matrix: Array, limit: Array, z: Array) -> Array:
    """Minimise the model over the step y - z with matrix @ y <= limit; y."""
    proxqp = load_proxqp()
    room = limit - matrix @ z - INSET
    if not (np.all(np.isfinite(hessian)) and np.all(np.isfinite(room))):
        raise SolverError("ProxQP was given numbers that are not finite")
    if np.linalg.eigvalsh(hessian)[0] <= 0.0:
        raise SolverError("ProxQP was given a Hessian that is not positive definite")
    qp = proxqp.dense.QP(z.size, 0, len(matrix))
    qp.settings.eps_abs, qp.settings.eps_rel = EPS, 0.0
    qp.settings.check_duality_gap = True
    qp.settings.eps_duality_gap_abs, qp.settings.eps_duality_gap_rel = EPS, 0.0
    qp.settings.max_iter = 2000
    qp.init(hessian, slope, None, None, matrix, np.full(len(matrix), -1e20), room)
    qp.solve()
    step = np.asarray(qp.results.x)
    if not np.all(np.isfinite(step)) or np.max(matrix @ step - room, initial=0.0) > INSET:
        raise SolverError(f"ProxQP ended with {qp.results.info.status}")
    return np.asarray(z + step)
