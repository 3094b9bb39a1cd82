"""Factors of many small matrices, one by one and all at once."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.forces.cholesky import FEW, Cholesky


@pytest.mark.parametrize("batch", [1, FEW, FEW + 1, 200])
@pytest.mark.parametrize("size", [1, 2, 6])
def test_solutions_solve(batch, size):
    rng = np.random.default_rng(batch + size)
    root = rng.normal(size=(size, size, batch))
    matrix = np.einsum("ikb,jkb->ijb", root, root) + 0.1 * np.eye(size)[..., None]
    side = rng.normal(size=(size, 2, batch))
    factors = Cholesky(np.where(np.tri(size, dtype=bool)[..., None], matrix, np.nan))
    assert factors.positive.all()
    solution = factors.solve(side)
    assert np.einsum("ijb,jkb->ikb", matrix, solution) == pytest.approx(side, abs=1e-8)
    assert factors.solve(side[:, 0]) == pytest.approx(solution[:, 0])


@pytest.mark.parametrize("batch", [3, FEW + 3])
def test_indefinite_matrices_are_named_and_replaced(batch):
    matrix = np.repeat(np.eye(3)[..., None], batch, axis=-1)
    matrix[1, 1, 2] = -1.0
    factors = Cholesky(matrix)
    assert np.nonzero(~factors.positive)[0].tolist() == [2]
    factors.replace(np.array([2]), 4.0 * np.eye(3)[..., None])
    assert factors.positive.all()
    wanted = np.ones((3, batch))
    wanted[:, 2] = 0.25
    assert factors.solve(np.ones((3, batch))) == pytest.approx(wanted)
