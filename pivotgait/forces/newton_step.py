"""One predictor-corrector step of the batched interior-point method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces.cholesky import Cholesky
from pivotgait.forces.cone_batch import ConeBatch, interior_log_barrier
from pivotgait.forces.goal import Goal

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
HALVINGS = 12
ROUNDING = 50.0
"""Units of rounding of its trace added to the Newton matrix's diagonal: a face of optima leaves
directions without curvature, which must stay above rounding."""


def advance(
    cones: ConeBatch,
    goal: Goal,
    z: Array,
    s: Array,
    dual: Array,
    value: Array,
    slope: Array,
    gap: Array,
    floor: Array,
) -> tuple[Array, Array, Array]:
    """New points (d, B), their slacks (q, B) and duals (q, B).

    Nesterov-Todd scaling, Mehrotra's centring and second-order correction, one step length for
    primal and dual; a smooth goal's primal step is cut until the barrier function falls.

    Args:
        cones: the constraints.
        goal: the objective.
        z: (d, B) strictly feasible points.
        s: (q, B) their slacks.
        dual: (q, B) interior duals.
        value: (B,) the goal.
        slope: (d, B) its gradient.
        gap: (B,) complementarity s . dual.
        floor: (B,) least barrier weight.
    """
    c3 = 3 * cones.cones
    cone, line = cones.split(s)
    dual_cone, dual_line = cones.split(dual)
    det, det_dual = algebra.determinant(cone), algebra.determinant(dual_cone)
    w, factor = algebra.scaling(cone, dual_cone, det, det_dual)
    square, square_line = algebra.squared(w, factor), dual_line / line
    inverse = np.concatenate(((algebra.reflect(cone) / det).reshape(c3, s.shape[1]), 1.0 / line))

    def edge(ds: Array, ddual: Array) -> Array:
        ds_cone, ds_line = cones.split(ds)
        ddual_cone, ddual_line = cones.split(ddual)
        shrink = np.concatenate(
            (
                algebra.shrink(cone, ds_cone, det),
                algebra.shrink(dual_cone, ddual_cone, det_dual),
                -ds_line / line,
                -ddual_line / dual_line,
            )
        )
        return np.asarray(1.0 / np.maximum(shrink.max(axis=0), 1e-10))

    def weigh(ds: Array) -> Array:
        weighed = np.einsum("ijcb,jcb->icb", square, cones.split(ds)[0]).reshape(c3, s.shape[1])
        return np.concatenate((weighed, square_line * ds[c3:]))

    factors = _newton_factors(cones, goal, s, square, square_line)
    sides = np.stack((-slope, cones.transposed(inverse)), axis=1)
    affine, centre = np.moveaxis(factors.solve(sides), 1, 0)

    # Mehrotra: how far the pure Newton (affine) step goes decides how much to centre ...
    ds = cones.image(affine)
    ddual = -dual - weigh(ds)
    weight = (1.0 - np.minimum(edge(ds, ddual), 1.0)) ** 3 * gap / cones.degree
    weight = np.maximum(weight, floor)

    # ... and its second-order error in the complementarity is taken back.
    scaled, moved = algebra.scale(w, factor, cone), algebra.scale(w, factor, cones.split(ds)[0])
    second = algebra.divide(algebra.product(moved, scaled + moved), scaled)
    error = np.concatenate(
        (algebra.scale(w, factor, second).reshape(c3, s.shape[1]), -ds[c3:] * ddual[c3:] / line)
    )
    plain = affine + weight * centre
    central = weight * inverse - dual
    dz, aim = plain + factors.solve(cones.transposed(error)), central + error
    ds = cones.image(dz)
    ddual = aim - weigh(ds)
    step = np.minimum(1.0, np.clip(1.0 - weight, 0.99, 0.999) * edge(ds, ddual))
    primal = step
    if goal.smooth is not None:
        now = value + weight * interior_log_barrier(det, line)
        uphill = ~(_merit(cones, goal, s + step * ds, weight) <= now)
        if uphill.any():
            # For a curved goal the correction may point uphill: then do without.
            dz, aim = np.where(uphill, plain, dz), np.where(uphill, central, aim)
            ds = cones.image(dz)
            ddual = aim - weigh(ds)
            step = np.minimum(1.0, np.clip(1.0 - weight, 0.99, 0.999) * edge(ds, ddual))
            few = np.nonzero(uphill)[0]
            primal = np.array(step)
            primal[few] = _line_search(
                cones.take(few),
                goal.take(few),
                s[:, few],
                ds[:, few],
                step[few],
                weight[few],
                now[few],
            )
    z = z + primal * dz
    return z, cones.slack(z), dual + step * ddual


def _line_search(
    cones: ConeBatch, goal: Goal, s: Array, ds: Array, step: Array, weight: Array, now: Array
) -> Array:
    """(B,) steps halved until the barrier function falls below ``now``."""
    for _ in range(HALVINGS):
        uphill = ~(_merit(cones, goal, s + step * ds, weight) <= now)
        if not uphill.any():
            break
        step = np.where(uphill, 0.5 * step, step)
    return step


def _merit(cones: ConeBatch, goal: Goal, s: Array, weight: Array) -> Array:
    """Barrier function; inf outside."""
    inside, barrier = cones.log_barrier(s)
    if not inside.all():
        s = np.where(inside, s, 1.0)
    merit = goal.value(cones, s[:0], s) + weight * barrier
    return np.where(inside, merit, np.inf)


def _newton_factors(
    cones: ConeBatch, goal: Goal, s: Array, square: Array, square_line: Array
) -> Cholesky:
    """Factors of the Hessian of the goal plus the scaled constraints.

    The exact Hessian of ``alignment`` where that is positive definite, else its convex part.
    """
    if goal.smooth is None:
        return Cholesky(_normal_matrix(cones, square, square_line))
    exact = square + goal.curvature(cones, s, concave=1.0)
    normal = _normal_matrix(cones, exact, square_line)
    factors = Cholesky(normal)
    bad = np.nonzero(~factors.positive)[0]
    if bad.size:
        some = cones.take(bad)
        block = square[..., bad] + goal.take(bad).curvature(some, s[:, bad], concave=0.0)
        factors.replace(bad, _normal_matrix(some, block, square_line[:, bad]))
    return factors


def _normal_matrix(cones: ConeBatch, block: Array, line: Array) -> Array:
    """(d, d, B) matrix' W matrix with W (3, 3, c, B) on the cones; its lower triangle only."""
    q, d, batch = cones.matrix.shape
    c3 = 3 * cones.cones
    product = np.empty((q, d, batch), dtype=block.dtype)
    rows = cones.matrix[:c3].reshape(3, cones.cones, d, batch)
    np.einsum("ijcb,jcdb->icdb", block, rows, out=product[:c3].reshape(3, cones.cones, d, batch))
    np.multiply(line[:, None], cones.matrix[c3:], out=product[c3:])
    normal = np.zeros((d, d, batch), dtype=block.dtype)
    for i in range(d):
        np.einsum("qb,qjb->jb", cones.matrix[:, i], product[:, : i + 1], out=normal[i, : i + 1])
    diagonal = np.einsum("iib->ib", normal)
    diagonal += ROUNDING * np.finfo(block.dtype).eps * diagonal.sum(axis=0)
    return normal
