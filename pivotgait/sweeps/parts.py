"""A sweep's cells in parts: some cells in a row, computed by one worker, kept in one file."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace

from pivotgait.sweeps.guard import CHILD, Guard
from pivotgait.sweeps.part_files import PartImage, part_image
from pivotgait.sweeps.study import Study
from pivotgait.sweeps.study_config import Compute

PART_CELLS: Mapping[Compute, int] = {"static": 500, "removal": 16, "plan": 1, "trials": 1}
"""Cells of a part: about a second's work where that is many, so that a kill costs little."""
TOGETHER: frozenset[Compute] = frozenset({"static"})
"""Computations that solve the cells of a part at once, which is faster; others take one by one."""
MAX_PARTS = 10_000
"""Of a sweep; more files than that make folders slow, so parts grow instead."""


@dataclass(frozen=True)
class Parts:
    """How a sweep is cut, which depends on the study alone: not on who computes it, or when.

    Attributes:
        cells: number of cells.
        size: cells of a part; the last one may have fewer.
    """

    cells: int
    size: int

    @classmethod
    def of(cls, study: Study) -> Parts:
        """The parts of a study."""
        return cls.cut(study.config.compute, study.cells.count)

    @classmethod
    def cut(cls, compute: Compute, cells: int) -> Parts:
        """The parts of so many cells of a computation."""
        return cls(cells, max(PART_CELLS[compute], -(-cells // MAX_PARTS)))

    @property
    def count(self) -> int:
        """Number of parts."""
        return -(-self.cells // self.size)

    def numbers(self, part: int) -> range:
        """Numbers of the cells of a part."""
        return range(part * self.size, min((part + 1) * self.size, self.cells))


@dataclass(frozen=True)
class PartTask:
    """A part as it goes to a worker.

    Attributes:
        study: as :meth:`Study.to_json` tells it.
        part: its number.
        limit_s: of a cell [s].
        command: of the computing process.
    """

    study: str
    part: int
    limit_s: float
    command: tuple[str, ...] = CHILD


class _Desk(threading.local):
    """What a worker's thread keeps from one part to the next: a study and its process."""

    task: PartTask | None = None
    study: Study | None = None
    guard: Guard | None = None


_DESK = _Desk()


def compute_part(task: PartTask) -> PartImage:
    """Compute the cells of a part; made for a worker, which keeps the computing process.

    Raises:
        SweepError, InputError: the computing process does not start or refuses the study.
    """
    if _DESK.task is None or replace(_DESK.task, part=task.part) != task:
        if _DESK.guard is not None:
            _DESK.guard.close()
        _DESK.task, _DESK.study = task, Study.from_json(task.study)
        _DESK.guard = Guard(task.study, task.limit_s, task.command)
    assert _DESK.study is not None
    assert _DESK.guard is not None
    numbers = Parts.of(_DESK.study).numbers(task.part)
    timed = _DESK.guard.outcomes(numbers, together=_DESK.study.config.compute in TOGETHER)
    return part_image(_DESK.study, task.part, numbers, timed)
