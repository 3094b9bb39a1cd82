"""One predictor-corrector step of the batched interior-point method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces.cone_batch import ConeBatch
from pivotgait.forces.goal import Goal

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
HALVINGS = 12
ROUNDING = 1e-14
"""Share of its trace added to the Newton matrix's diagonal: a face of optima leaves directions
without curvature, which must stay above rounding."""


def advance(
    cones: ConeBatch,
    goal: Goal,
    z: Array,
    s: Array,
    dual: Array,
    slope: Array,
    gap: Array,
    floor: Array,
) -> tuple[Array, Array, Array]:
    """New points (B, d), their slacks (B, q) and duals (B, q).

    Nesterov-Todd scaling, Mehrotra's centring and second-order correction, one step length for
    primal and dual; a smooth goal's primal step is cut until the barrier function falls.

    Args:
        cones: the constraints.
        goal: the objective.
        z: (B, d) strictly feasible points.
        s: (B, q) their slacks.
        dual: (B, q) interior duals.
        slope: (B, d) gradient of the goal.
        gap: (B,) complementarity s . dual.
        floor: (B,) least barrier weight.
    """
    c3 = 3 * cones.cones
    cone, line = cones.split(s)
    dual_cone, dual_line = cones.split(dual)
    det, det_dual = algebra.determinant(cone), algebra.determinant(dual_cone)
    w, factor = algebra.scaling(cone, dual_cone, det, det_dual)
    square, square_line = algebra.squared(w, factor), dual_line / line
    inverse = np.empty_like(s)
    inverse[:, :c3] = (algebra.reflect(cone) / det[..., None]).reshape(len(s), c3)
    inverse[:, c3:] = 1.0 / line

    def edge(ds: Array, ddual: Array) -> Array:
        ds_cone, ds_line = cones.split(ds)
        ddual_cone, ddual_line = cones.split(ddual)
        shrink = np.maximum(
            algebra.shrink(cone, ds_cone, det),
            algebra.shrink(dual_cone, ddual_cone, det_dual),
        ).max(axis=1, initial=0.0)
        fall = np.maximum(-ds_line / line, -ddual_line / dual_line).max(axis=1, initial=0.0)
        return np.asarray(1.0 / np.maximum(np.maximum(shrink, fall), 1e-10))

    def weigh(ds: Array) -> Array:
        out = np.empty_like(ds)
        out[:, :c3] = (square @ cones.split(ds)[0][..., None]).reshape(len(ds), c3)
        out[:, c3:] = square_line * ds[:, c3:]
        return out

    newton = _newton_matrix(cones, goal, s, square, square_line)
    sides = np.stack((-slope, cones.transposed(inverse)), axis=2)
    steps: Array = np.asarray(np.linalg.solve(newton, sides), dtype=float)

    # Mehrotra: how far the pure Newton (affine) step goes decides how much to centre ...
    ds = cones.image(steps[..., 0])
    ddual = -dual - weigh(ds)
    weight = (1.0 - np.minimum(edge(ds, ddual), 1.0)) ** 3 * gap / cones.degree
    weight = np.maximum(weight, floor)

    # ... and its second-order error in the complementarity is taken back.
    error = np.empty_like(s)
    scaled, moved = algebra.scale(w, factor, cone), algebra.scale(w, factor, cones.split(ds)[0])
    second = algebra.divide(algebra.product(moved, scaled + moved), scaled)
    error[:, :c3] = algebra.scale(w, factor, second).reshape(len(s), c3)
    error[:, c3:] = -ds[:, c3:] * ddual[:, c3:] / line
    correct = np.linalg.solve(newton, cones.transposed(error)[..., None])[..., 0]

    plain = steps[..., 0] + weight[:, None] * steps[..., 1]
    central = weight[:, None] * inverse - dual
    dz, aim = plain + correct, central + error
    ds = cones.image(dz)
    if goal.smooth is not None:
        # For a curved goal the correction may point uphill: then do without.
        ddual = aim - weigh(ds)
        now = _merit(cones, goal, s, weight)
        step = np.minimum(1.0, 0.99 * edge(ds, ddual))
        uphill = ~(_merit(cones, goal, s + step[:, None] * ds, weight) <= now)
        if uphill.any():
            dz[uphill], aim[uphill] = plain[uphill], central[uphill]
            ds = cones.image(dz)
    ddual = aim - weigh(ds)
    step = np.minimum(1.0, np.clip(1.0 - weight, 0.99, 0.999) * edge(ds, ddual))
    primal = step
    if goal.smooth is not None and uphill.any():
        for _ in range(HALVINGS):
            uphill &= ~(_merit(cones, goal, s + primal[:, None] * ds, weight) <= now)
            if not uphill.any():
                break
            primal = np.where(uphill, 0.5 * primal, primal)
    z = z + primal[:, None] * dz
    return z, cones.slack(z), dual + step[:, None] * ddual


def _merit(cones: ConeBatch, goal: Goal, s: Array, weight: Array) -> Array:
    """Barrier function, up to rounding; inf outside."""
    inside, barrier = cones.log_barrier(s)
    if not inside.all():
        s = np.where(inside[:, None], s, 1.0)
    merit = goal.value(cones, s[:, :0], s) + weight * barrier
    return np.where(inside, merit - 1e-12 * (1.0 + np.abs(merit)), np.inf)


def _newton_matrix(
    cones: ConeBatch, goal: Goal, s: Array, square: Array, square_line: Array
) -> Array:
    """(B, d, d) Hessian of the goal plus the scaled constraints, positive definite.

    The exact Hessian of ``alignment`` where that is positive definite, else its convex part.
    """
    if goal.smooth is None:
        return _normal_matrix(cones, square, square_line)
    exact = square + goal.curvature(cones, s, concave=1.0)
    newton = _normal_matrix(cones, exact, square_line)
    if goal.smooth == "alignment":
        part = np.nonzero(~_positive_definite(newton))[0]
        if part.size:
            some = cones.take(part)
            convex = goal.take(part).curvature(some, s[part], concave=0.0)
            newton[part] = _normal_matrix(some, square[part] + convex, square_line[part])
    return newton


def _normal_matrix(cones: ConeBatch, block: Array, line: Array) -> Array:
    batch, q, d = cones.matrix.shape
    c3 = 3 * cones.cones
    product = np.empty((batch, q, d))
    rows = cones.matrix[:, :c3].reshape(batch, cones.cones, 3, d)
    np.matmul(block, rows, out=product[:, :c3].reshape(batch, cones.cones, 3, d))
    np.multiply(line[..., None], cones.matrix[:, c3:], out=product[:, c3:])
    normal = np.swapaxes(cones.matrix, 1, 2) @ product
    diagonal = np.einsum("bii->bi", normal)
    diagonal += ROUNDING * diagonal.sum(axis=1, keepdims=True)
    return np.asarray(normal)


def _positive_definite(matrix: Array) -> Mask:
    """(B,) whether all pivots of a Cholesky factorisation are positive."""
    rest = np.array(matrix)
    positive = np.ones(len(rest), dtype=bool)
    for _ in range(rest.shape[1]):
        positive &= rest[:, 0, 0] > 0.0
        pivot = np.where(positive, rest[:, 0, 0], 1.0)
        column = np.where(positive[:, None], rest[:, 1:, 0], 0.0)
        rest = rest[:, 1:, 1:] - column[:, :, None] * (column / pivot[:, None])[:, None]
    return positive
