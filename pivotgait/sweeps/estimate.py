"""How long a sweep will take, from a few of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pivotgait.sweeps.guard import CHILD, Guard
from pivotgait.sweeps.parts import TOGETHER, Parts
from pivotgait.sweeps.study import Study

_FEW = 4


@dataclass(frozen=True)
class Estimate:
    """What a sweep will be.

    Attributes:
        cells: number of cells.
        parts: number of files they go to.
        measured: number of cells it is judged by.
        cell_s: mean time of a cell on one worker [s].
    """

    cells: int
    parts: int
    measured: int
    cell_s: float

    def seconds(self, workers: int, *, done: int = 0) -> float:
        """Time that the cells which are not done take so many workers [s]."""
        return (self.cells - done) * self.cell_s / workers


def estimate(study: Study, *, command: Sequence[str] = CHILD) -> Estimate:
    """Compute a few cells, spread evenly over the sweep, and keep nothing but the time.

    Cells that are judged together are measured by the part, others one by one; one cell more
    is computed first, since the first one builds the solvers.

    Raises:
        SweepError, InputError: the computing process does not start or refuses the study.
    """
    parts, together = Parts.of(study), study.config.compute in TOGETHER
    count = min(parts.cells, parts.size if together else _FEW)
    numbers = [k * parts.cells // count for k in range(count)]
    guard = Guard(study.to_json(), study.config.limit_s, command)
    try:
        guard.outcomes(numbers[:1])
        times = [each.seconds for each in guard.outcomes(numbers, together=together)]
    finally:
        guard.close()
    return Estimate(parts.cells, parts.count, count, sum(times) / count)
