"""The edge of feasibility along a line of data, for many lines at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pivotgait.frozen import Array

Index = NDArray[np.intp]
Holds = Callable[[Index, Array], NDArray[np.bool_]]
"""(line of each trial (N,), value (N,)) -> (N,) whether the trial is feasible."""
POINTS = 3
"""Trials within a bracket in one round: bisection makes the fewest trials, but a batch of few costs
as much as one of more; of 1, 3 and 7 this is the quickest for a gait's margins."""


def last_feasible(start: Array, limit: Array, holds: Holds, *, rounds: int = 8) -> Array:
    """The value farthest from ``start`` up to which each line is feasible.

    Each round puts :data:`POINTS` trials into every bracket, which divides it by four. What is
    feasible must reach from the start to the edge without a gap, as it does along every convex
    set and wherever a limit only loosens.

    Args:
        start: (B,) values at the lines' beginnings.
        limit: (B,) values at their ends, above or below.
        holds: the trials, all of a round in one call.
        rounds: 8 leave the edge within 2e-5 of the line's length, on the feasible side.

    Returns:
        (B,) NaN where the start itself is infeasible, the limit where all of the line is feasible.
    """
    start, limit = (np.array(each, dtype=float) for each in np.broadcast_arrays(start, limit))
    count = len(start)
    lines = np.arange(count)
    ends = holds(np.tile(lines, 2), np.concatenate((start, limit))).reshape(2, count)
    inside, outside = start.copy(), limit.copy()
    inside[ends[0] & ends[1]] = limit[ends[0] & ends[1]]
    open_ = lines[ends[0] & ~ends[1]]
    share = np.arange(1, POINTS + 1) / (POINTS + 1)
    for _ in range(rounds if open_.size else 0):
        low, width = inside[open_], outside[open_] - inside[open_]
        trial = low[:, None] + share * width[:, None]
        good = holds(np.repeat(open_, POINTS), trial.reshape(-1)).reshape(trial.shape)
        reached = np.where(good.all(axis=1), POINTS, np.argmin(good, axis=1))
        inside[open_] = low + reached / (POINTS + 1) * width
        outside[open_] = low + (reached + 1) / (POINTS + 1) * width
    return np.where(ends[0], inside, np.nan)
