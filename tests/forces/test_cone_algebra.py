"""Laws of the second-order cone and of the objectives' derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces import objectives
from pivotgait.forces.cholesky import Cholesky


def interior(rng, count):
    s = rng.normal(size=(3, count))
    s[2] = np.hypot(s[0], s[1]) + 10.0 ** rng.uniform(-4, 1, count)
    return s


def test_the_scaling_maps_slack_to_dual():
    rng = np.random.default_rng(0)
    s, dual = interior(rng, 200), interior(rng, 200)
    w, factor = algebra.scaling(s, dual, algebra.determinant(s), algebra.determinant(dual))
    square = algebra.squared(w, factor)
    assert np.einsum("ijb,jb->ib", square, s) == pytest.approx(dual, rel=1e-8, abs=1e-8)
    twice = algebra.scale(w, factor, algebra.scale(w, factor, s))
    assert twice == pytest.approx(dual, rel=1e-8, abs=1e-8)


def test_division_undoes_the_jordan_product():
    rng = np.random.default_rng(1)
    a, b = interior(rng, 100), rng.normal(size=(3, 100))
    assert algebra.divide(algebra.product(a, b), a) == pytest.approx(b, rel=1e-8, abs=1e-8)
    inverse = algebra.reflect(a) / algebra.determinant(a)
    unit = np.tile(((0.0,), (0.0,), (1.0,)), 100)
    assert algebra.product(a, inverse) == pytest.approx(unit, abs=1e-9)


def test_the_step_ends_on_the_edge():
    rng = np.random.default_rng(2)
    s, ds = interior(rng, 500), rng.normal(size=(3, 500))
    shrink = algebra.shrink(s, ds, algebra.determinant(s))
    blocked = shrink > 1e-6
    assert 50 < blocked.sum() < 500
    step = 1.0 / shrink[blocked]
    edge = algebra.margin(s[:, blocked] + step * ds[:, blocked])
    assert np.abs(edge) == pytest.approx(np.zeros(len(step)), abs=1e-8 * (1 + step.max()))
    assert np.all(algebra.margin(s[:, blocked] + 0.999 * step * ds[:, blocked]) > 0)
    assert np.all(algebra.margin(s[:, ~blocked] + 1e3 * ds[:, ~blocked]) > 0)


@pytest.mark.parametrize("objective", objectives.SMOOTH)
def test_derivatives_match_differences(objective):
    rng = np.random.default_rng(3)
    x = rng.normal(size=(3, 50))
    x[2] = np.abs(x[2]) + 0.3
    x[:2, 0] = 0.0  # straight along the normal: no tangential direction
    slope = objectives.gradient(objective, x)
    curvature = objectives.hessian(objective, x, concave=1.0)
    for axis in range(3):
        h = np.zeros((3, 1))
        h[axis] = 1e-6
        rise = objectives.value(objective, x + h) - objectives.value(objective, x - h)
        assert slope[axis] == pytest.approx(rise / 2e-6, abs=1e-7)
        bend = objectives.gradient(objective, x + h) - objectives.gradient(objective, x - h)
        assert curvature[axis] == pytest.approx(bend / 2e-6, abs=1e-6)


def test_the_convex_part_is_the_nearest_semidefinite_one():
    x = np.random.default_rng(4).normal(size=(40, 3)) + np.array((0.0, 0.0, 3.0))
    exact = objectives.hessian("alignment", x.T, concave=1.0).T
    weight, axes = np.linalg.eigh(exact)
    nearest = (axes * np.maximum(weight, 0.0)[:, None]) @ np.swapaxes(axes, 1, 2)
    assert pytest.approx(nearest, abs=1e-12) == objectives.hessian("alignment", x.T).T
    assert np.all(weight[:, 0] < 0.0)


def test_cholesky_solves_and_knows_the_indefinite():
    rng = np.random.default_rng(5)
    a = rng.normal(size=(300, 5, 5))
    matrix = a @ np.swapaxes(a, 1, 2) - rng.uniform(0, 1, (300, 1, 1)) * np.eye(5)
    wanted = np.linalg.eigvalsh(matrix)[:, 0] > 0
    assert 20 < wanted.sum() < 280
    factors = Cholesky(np.moveaxis(matrix, 0, -1))
    assert np.array_equal(factors.positive, wanted)
    side = rng.normal(size=(5, 300))
    rest = np.einsum("bij,jb->ib", matrix, factors.solve(side)) - side
    assert np.abs(rest[:, wanted]).max() < 1e-7
