"""Where the states of a function on the unit square meet, by refining only there.

The square is cut into cells; those whose nodes differ in state are cut in four, down to the
wanted size. A border is followed wherever it leaves a cell, since the nodes that its neighbours
have put on a cell's edges count, too. What is smaller than a coarse cell and touches none of its
nodes may be missed; the values themselves tell where that is likely, and such cells are cut once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.frozen import Array

Index = NDArray[np.intp]
Evaluate = Callable[[Array], Array]
"""(n, 2) points of the unit square -> (3, n): state, what changes its sign where the state does
(NaN if nothing does), and any other value to keep. A state may be NaN."""
COARSE = 8
"""Cells along each side before any refinement."""
UNKNOWN, NONE = -2.0, -1.0


@dataclass(frozen=True, eq=False)
class Quadtree:
    """Nodes and cells of a refined square, on a lattice of ``side`` finest cells along each edge.

    Attributes:
        side: finest cells along an edge.
        state: (side + 1, side + 1) by place across and up; -1 for no state, -2 where it was not
            evaluated.
        signed: likewise, what changes its sign with the state; NaN where it was not evaluated.
        kept: likewise, the other value.
        leaves: (l, 3) lower corner and size of the cells that were not cut, in finest cells.
    """

    side: int
    state: Array
    signed: Array
    kept: Array
    leaves: Index

    @property
    def nodes(self) -> Index:
        """(n, 2) places of the evaluated nodes."""
        return np.argwhere(self.state != UNKNOWN)

    @property
    def grid(self) -> int:
        """Nodes of a grid that is everywhere as fine."""
        return (self.side + 1) ** 2

    def share(self, state: float) -> float:
        """Share of the square's area in a state: of each leaf the share of its corners."""
        i, j, size = self.leaves.T
        corners = [self.state[i + a * size, j + b * size] for a in (0, 1) for b in (0, 1)]
        return float(np.sum(np.mean(np.array(corners) == state, axis=0) * (size / self.side) ** 2))


def refine(evaluate: Evaluate, *, levels: int, coarse: int = COARSE) -> Quadtree:
    """Refine about every border.

    Args:
        evaluate: called with all the nodes of a round at once.
        levels: times a cell may be cut in four.
        coarse: cells along each side to begin with.
    """
    side = coarse << levels
    known = np.full((3, side + 1, side + 1), np.nan)
    known[0] = UNKNOWN
    size = side // coarse
    lower = np.arange(coarse) * size
    i, j = (each.reshape(-1) for each in np.meshgrid(lower, lower, indexing="ij"))
    leaves = np.stack((i, j, np.full_like(i, size)), axis=1)
    while True:
        _fill(evaluate, leaves, known)
        cut = np.array(
            [_is_cut(leaf, known[0], known[1], size) for leaf in leaves.tolist()], dtype=bool
        )
        if not cut.any():
            return Quadtree(side, known[0], known[1], known[2], leaves)
        leaves = np.concatenate((leaves[~cut], _quarters(leaves[cut])))


def _fill(evaluate: Evaluate, leaves: Index, known: Array) -> None:
    """Evaluate the leaves' corners that are not known."""
    i, j, size = leaves.T
    corners = [np.stack((i + a * size, j + b * size), axis=1) for a in (0, 1) for b in (0, 1)]
    places = np.unique(np.concatenate(corners), axis=0)
    new = places[known[0][tuple(places.T)] == UNKNOWN]
    if not len(new):
        return
    found = evaluate(new / (known.shape[1] - 1))
    known[:, new[:, 0], new[:, 1]] = found
    known[0, new[:, 0], new[:, 1]] = np.where(np.isnan(found[0]), NONE, found[0])


def _is_cut(leaf: list[int], state: Array, signed: Array, coarse_size: int) -> bool:
    i, j, size = leaf
    if size == 1:
        return False
    part = np.s_[i : i + size + 1, j : j + size + 1]
    known = state[part][state[part] != UNKNOWN]
    if np.any(known != known[0]):
        return True
    # A cell that still has its first size is cut where the values fall towards 0 so fast that
    # the state may change between its nodes.
    here = signed[part][np.isfinite(signed[part])]
    if size < coarse_size or known[0] == NONE or len(here) < len(known):
        return False
    return bool(np.abs(here).min() < 0.5 * np.ptp(here))


def _quarters(leaves: Index) -> Index:
    i, j, size = leaves.T
    half = size // 2
    return np.concatenate(
        [np.stack((i + a * half, j + b * half, half), axis=1) for a in (0, 1) for b in (0, 1)]
    )
