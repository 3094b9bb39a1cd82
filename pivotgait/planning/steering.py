"""Straight lines in the joints, projected on the closed chain step by step."""

from __future__ import annotations

from collections.abc import Iterator

from pivotgait.frozen import Array
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.validity import Validity

ARRIVED = 1e-9
"""Bound on motion below which two states are one [m]."""
LEAST_GAIN = 0.3
"""Share of a step's way below which projection has taken back too much of it."""


def steer(
    manifold: Manifold,
    validity: Validity,
    begin: tuple[Array, float],
    end: tuple[Array, float],
    stride: float,
) -> Iterator[tuple[Array, float]]:
    """Free states towards ``end``, each within ``stride`` [m] of the last, until blocked.

    The last one is ``end`` itself (the same array) if the whole way is free. Why it was blocked
    is counted in the manifold's counts.
    """
    (q, s), (q_end, s_end) = begin, end
    while (left := manifold.motion(q, s, q_end, s_end)) > ARRIVED:
        share = min(1.0, stride / left)
        s_next = s + share * (s_end - s)
        if share == 1.0:
            settled: Array | None = q_end
        else:
            settled = manifold.settle(q + share * (q_end - q), s_next)
        if settled is None:
            return
        gained = left - manifold.motion(settled, s_next, q_end, s_end)
        if gained < LEAST_GAIN * share * left:
            manifold.counts.stalled += 1
            return
        if not validity.way_free(q, s, settled, s_next):
            manifold.counts.collision += 1
            return
        q, s = settled, s_next
        yield q, s
