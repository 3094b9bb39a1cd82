"""The line between two states of a refined square: marching squares over its finest cells."""

from __future__ import annotations

import numpy as np

from pivotgait.feasibility.quadtree import NONE, Quadtree
from pivotgait.frozen import Array

CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Of a cell, around it; edge k goes from corner k to the next."""


def border(tree: Quadtree, inside: float = 1.0) -> Array:
    """(s, 2, 2) segments between nodes of state ``inside`` and the others, in the unit square.

    Where the values change sign along a cell's edge the border is put at the zero between them,
    otherwise (no value, or an infinite one) in the middle. It is within the diagonal of a finest
    cell of the true one. Nodes of no state count as outside.
    """
    segments = []
    for i, j, size in tree.leaves.tolist():
        if size > 1:
            continue
        nodes = [(i + a, j + b) for a, b in CORNERS]
        kept = [tree.state[node] == inside for node in nodes]
        crossed = [k for k in range(4) if kept[k] != kept[(k + 1) % 4]]
        points = [_crossing(tree, nodes[k], nodes[(k + 1) % 4]) for k in crossed]
        # of a saddle's four points each pair cuts off a corner of state ``inside``
        pairs = ((0, 1), (2, 3)) if not kept[0] else ((3, 0), (1, 2))
        joined = {0: (), 2: ((0, 1),), 4: pairs}[len(points)]
        segments += [(points[a], points[b]) for a, b in joined]
    return np.array(segments, dtype=float).reshape(-1, 2, 2) / tree.side


def _crossing(tree: Quadtree, one: tuple[int, int], other: tuple[int, int]) -> Array:
    a, b = tree.signed[one], tree.signed[other]
    share = 0.5
    known = tree.state[one] != NONE and tree.state[other] != NONE
    if known and np.isfinite(a) and np.isfinite(b) and (a >= 0.0) != (b >= 0.0):
        share = float(a / (a - b))
    return (1.0 - share) * np.array(one) + share * np.array(other)
