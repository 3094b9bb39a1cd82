"""Laws of the second-order cone and of the objectives' derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.forces import cone_algebra as algebra
from pivotgait.forces import objectives
from pivotgait.forces.newton_step import _positive_definite


def interior(rng, count):
    s = rng.normal(size=(count, 3))
    s[:, 2] = np.hypot(s[:, 0], s[:, 1]) + 10.0 ** rng.uniform(-4, 1, count)
    return s


def test_the_scaling_maps_slack_to_dual():
    rng = np.random.default_rng(0)
    s, dual = interior(rng, 200), interior(rng, 200)
    w, factor = algebra.scaling(s, dual, algebra.determinant(s), algebra.determinant(dual))
    square = algebra.squared(w, factor)
    assert (square @ s[..., None])[..., 0] == pytest.approx(dual, rel=1e-8, abs=1e-8)
    twice = algebra.scale(w, factor, algebra.scale(w, factor, s))
    assert twice == pytest.approx(dual, rel=1e-8, abs=1e-8)


def test_division_undoes_the_jordan_product():
    rng = np.random.default_rng(1)
    a, b = interior(rng, 100), rng.normal(size=(100, 3))
    assert algebra.divide(algebra.product(a, b), a) == pytest.approx(b, rel=1e-8, abs=1e-8)
    inverse = algebra.reflect(a) / algebra.determinant(a)[:, None]
    assert algebra.product(a, inverse) == pytest.approx(np.tile((0, 0, 1), (100, 1)), abs=1e-9)


def test_the_step_ends_on_the_edge():
    rng = np.random.default_rng(2)
    s, ds = interior(rng, 500), rng.normal(size=(500, 3))
    shrink = algebra.shrink(s, ds, algebra.determinant(s))
    blocked = shrink > 1e-6
    assert 50 < blocked.sum() < 500
    step = 1.0 / shrink[blocked]
    edge = algebra.margin(s[blocked] + step[:, None] * ds[blocked])
    assert np.abs(edge) == pytest.approx(np.zeros(len(step)), abs=1e-8 * (1 + step.max()))
    assert np.all(algebra.margin(s[blocked] + 0.999 * step[:, None] * ds[blocked]) > 0)
    assert np.all(algebra.margin(s[~blocked] + 1e3 * ds[~blocked]) > 0)


@pytest.mark.parametrize("objective", objectives.SMOOTH)
def test_derivatives_match_differences(objective):
    rng = np.random.default_rng(3)
    x = rng.normal(size=(50, 3))
    x[:, 2] = np.abs(x[:, 2]) + 0.3
    x[0, :2] = 0.0  # straight along the normal: no tangential direction
    slope = objectives.gradient(objective, x)
    curvature = objectives.hessian(objective, x, concave=1.0)
    for axis in range(3):
        h = np.zeros(3)
        h[axis] = 1e-6
        rise = objectives.value(objective, x + h) - objectives.value(objective, x - h)
        assert slope[:, axis] == pytest.approx(rise / 2e-6, abs=1e-7)
        bend = objectives.gradient(objective, x + h) - objectives.gradient(objective, x - h)
        assert curvature[:, axis] == pytest.approx(bend / 2e-6, abs=1e-6)


def test_the_convex_part_is_the_nearest_semidefinite_one():
    x = np.random.default_rng(4).normal(size=(40, 3)) + np.array((0.0, 0.0, 3.0))
    exact = objectives.hessian("alignment", x, concave=1.0)
    weight, axes = np.linalg.eigh(exact)
    nearest = (axes * np.maximum(weight, 0.0)[:, None]) @ np.swapaxes(axes, 1, 2)
    assert objectives.hessian("alignment", x) == pytest.approx(nearest, abs=1e-12)
    assert np.all(weight[:, 0] < 0.0)


def test_positive_definiteness_is_that_of_the_eigenvalues():
    rng = np.random.default_rng(5)
    a = rng.normal(size=(300, 5, 5))
    matrix = a @ np.swapaxes(a, 1, 2) - rng.uniform(0, 1, (300, 1, 1)) * np.eye(5)
    wanted = np.linalg.eigvalsh(matrix)[:, 0] > 0
    assert 20 < wanted.sum() < 280
    assert np.array_equal(_positive_definite(matrix), wanted)
