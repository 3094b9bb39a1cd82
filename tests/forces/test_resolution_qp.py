"""The program within limits: its answer is the best, and the same wherever memory lies."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.forces.resolution_qp import EPS, ResolutionQp
from pivotgait.frozen import Array

SIZE, ROWS = 19, 38
Program = tuple[Array, Array, Array, Array, Array]


@pytest.fixture(scope="module")
def programs() -> list[Program]:
    rng = np.random.default_rng(0)
    found = []
    for _ in range(20):
        root = rng.normal(size=(SIZE, SIZE))
        rows = np.vstack((np.eye(SIZE), rng.normal(size=(ROWS - SIZE, SIZE))))
        limit = np.full(ROWS, 0.5)
        hessian = root @ root.T + 1e-3 * np.eye(SIZE)
        found.append((hessian, 10.0 * rng.normal(size=SIZE), rows, -limit, limit))
    return found


def answers(programs: list[Program]) -> Array:
    """Of one solver that starts each from the answer before."""
    solver = ResolutionQp(SIZE, ROWS)
    found = [solver.solve(*program) for program in programs]
    assert all(x is not None for x in found)
    return np.array(found)


def test_answers_are_optimal(programs: list[Program]) -> None:
    """No step along the gradient that the limits allow: projected onto them, x stays."""
    for (hessian, slope, rows, lower, upper), x in zip(programs, answers(programs), strict=True):
        value = rows @ x
        assert np.all((value >= lower - EPS) & (value <= upper + EPS))
        active = (value < lower + 1e-5) | (value > upper - 1e-5)
        push = np.linalg.lstsq(rows[active].T, -(hessian @ x + slope), rcond=None)[0]
        np.testing.assert_allclose(rows[active].T @ push, -(hessian @ x + slope), atol=1e-4)
        assert np.all(push * np.sign(value[active]) > -1e-4)


def test_answers_do_not_depend_on_where_memory_lies(programs: list[Program]) -> None:
    """Blocks of odd sizes move all later ones by multiples of 16 bytes."""
    rng = np.random.default_rng(1)
    first, held = answers(programs), []
    for _ in range(8):
        held += [bytes(int(size)) for size in rng.integers(600, 6000, 2000)]
        held = [held[k] for k in rng.permutation(len(held))[: len(held) // 2]]
        np.testing.assert_array_equal(answers(programs), first)
