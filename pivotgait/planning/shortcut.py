"""Random shortcuts of a path on the closed chain's manifold."""

from __future__ import annotations

import numpy as np

from pivotgait.frozen import Array
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.steering import steer
from pivotgait.planning.validity import Validity

LEAST_SAVING = 1e-3
"""Of a path's length that a shortcut must save, as a share of what it replaces."""
MOST_VAIN = 15
"""Attempts in a row without a saving after which a path counts as short."""


def path_length(manifold: Manifold, q: Array, s: Array) -> float:
    """Sum of the bounds on motion along a path of states [m]."""
    return float(manifold.motions(q, s).sum())


def shorten(
    manifold: Manifold,
    validity: Validity,
    q: Array,
    s: Array,
    attempts: int,
    stride: float,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """A path with the same ends that is no longer, by random shortcuts.

    Args:
        manifold: of the problem.
        validity: of the problem.
        q: (N, nv) free states, neighbours within ``stride``.
        s: (N,) parameter of the tool's path at each.
        attempts: number of shortcuts tried; the first is from end to end.
        stride: longest step between two projections [m].
        rng: source of randomness.

    Returns:
        q (M, nv) and s (M,).
    """
    vain = 0
    for attempt in range(attempts):
        if vain >= MOST_VAIN:
            break
        at = np.concatenate(([0.0], np.cumsum(manifold.motions(q, s))))
        drawn = np.array([0.0, at[-1]]) if attempt == 0 else np.sort(rng.uniform(0, at[-1], 2))
        i = int(np.searchsorted(at, drawn[0], side="right")) - 1
        j = min(int(np.searchsorted(at, drawn[1])), len(s) - 1)
        vain += 1
        if j - i < 2:
            continue
        begin, end = (q[i], float(s[i])), (q[j], float(s[j]))
        if manifold.motion(*begin, *end) > (1.0 - LEAST_SAVING) * (at[j] - at[i]):
            continue
        states = list(steer(manifold, validity, begin, end, stride))
        if not states or states[-1][0] is not end[0]:
            continue
        new_q = np.array([begin[0], *(state[0] for state in states)])
        new_s = np.array([begin[1], *(state[1] for state in states)])
        if path_length(manifold, new_q, new_s) < (1.0 - LEAST_SAVING) * (at[j] - at[i]):
            q = np.concatenate((q[:i], new_q, q[j + 1 :]))
            s = np.concatenate((s[:i], new_s, s[j + 1 :]))
            vain = 0
    return q, s
