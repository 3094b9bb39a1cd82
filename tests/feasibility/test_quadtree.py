"""Refinement finds the border that a fine grid would, with a fraction of its points."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.feasibility.borders import border
from pivotgait.feasibility.quadtree import NONE, refine

CASES = {
    "disc": lambda x, y: 0.3 - np.hypot(x - 0.45, y - 0.55),
    "line": lambda x, y: x + 0.3 * y - 0.611,
    "ring": lambda x, y: 0.1 - np.abs(np.hypot(x - 0.5, y - 0.5) - 0.3),
    "corner": lambda x, y: np.minimum(x - 0.31, y - 0.52),
}


def asked(depth):
    """An evaluator of a depth function that counts its points."""
    calls = []

    def evaluate(points):
        calls.append(len(points))
        value = depth(*points.T)
        return np.stack((np.where(value >= 0.0, 1.0, 0.0), value, 2.0 * value))

    return evaluate, calls


@pytest.mark.parametrize("name", CASES)
def test_every_change_of_a_fine_grid_is_on_the_border(name):
    depth = CASES[name]
    evaluate, calls = asked(depth)
    tree = refine(evaluate, levels=4)
    ends = border(tree)
    assert sum(calls) == len(tree.nodes) < 0.2 * tree.grid
    x, y = np.meshgrid(np.arange(tree.side + 1), np.arange(tree.side + 1), indexing="ij")
    holds = depth(x / tree.side, y / tree.side) >= 0.0
    changes = np.argwhere(holds[1:] != holds[:-1]) + np.array([0.5, 0.0])
    middles = ends.mean(axis=1) * tree.side
    nearest = np.min(np.linalg.norm(changes[:, None] - middles, axis=2), axis=1)
    assert nearest.max() <= np.sqrt(2.0)
    assert tree.share(1.0) == pytest.approx(holds.mean(), abs=0.01)


@pytest.mark.parametrize("name", CASES)
def test_the_border_is_where_the_depth_is_zero(name):
    tree = refine(asked(CASES[name])[0], levels=4)
    ends = border(tree).reshape(-1, 2)
    assert np.abs(CASES[name](*ends.T)).max() < 0.2 / tree.side
    # each end belongs to two segments, but for those at the edge of the square
    inner = ends[np.all((ends > 1e-9) & (ends < 1.0 - 1e-9), axis=1)]
    _, count = np.unique(np.round(inner, 9), axis=0, return_counts=True)
    assert set(count.tolist()) == {2}


def test_without_a_border_nothing_is_refined():
    evaluate, calls = asked(lambda x, y: 5.0 + x + y)
    tree = refine(evaluate, levels=6)
    assert calls == [81]
    assert border(tree).shape == (0, 2, 2)
    assert tree.share(1.0) == 1.0


def test_what_is_no_scene_is_outside():
    def evaluate(points):
        there = points[:, 0] < 0.5
        state = np.where(there, 1.0, np.nan)
        return np.stack((state, np.where(there, 1.0, np.nan), state))

    tree = refine(evaluate, levels=3)
    ends = border(tree)
    assert np.abs(ends[..., 0] - 0.5).max() <= 1.0 / tree.side
    assert tree.share(NONE) == pytest.approx(0.5, abs=0.02)


def test_a_disc_smaller_than_a_coarse_cell_is_found_where_the_depth_falls():
    def depth(x, y):
        return 0.04 - np.hypot(x - 0.55, y - 0.57)

    assert refine(asked(depth)[0], levels=4).share(1.0) > 0.0
