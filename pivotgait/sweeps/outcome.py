"""What becomes of a cell: its numbers, or the reason why there are none."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

from pivotgait.exceptions import InfeasibleError, InputError, PivotGaitError
from pivotgait.sweeps.cells import Cell

Status = Literal["done", "invalid", "unsolved", "error", "timeout", "crash"]
STATUSES: Mapping[Status, str] = {
    "done": "computed, feasible or not",
    "invalid": "the values make no scene",
    "unsolved": "a solver gave up",
    "error": "a defect",
    "timeout": "the time limit was reached",
    "crash": "the process died",
}
Kind = Literal["bool", "int", "float", "text"]
Columns = Mapping[str, Kind]
"""Of a computation's results; ``feasible`` is one of them."""
Result = bool | int | float | str | None
REASON_LENGTH = 500


@dataclass(frozen=True)
class Outcome:
    """Of one cell.

    Attributes:
        status: see :data:`STATUSES`.
        reason: why it is not done, or not feasible; else empty.
        results: column -> value; columns left out are empty.
    """

    status: Status
    reason: str = ""
    results: Mapping[str, Result] = field(default_factory=dict)


class Computation(Protocol):
    """What a study computes for each cell."""

    def outcomes(self, cells: Sequence[Cell]) -> list[Outcome]:
        """Of some cells, in their order; a cell that fails is an outcome."""


def attempt(compute: Callable[[], Mapping[str, Result]]) -> Outcome:
    """The outcome of computing one cell."""
    try:
        return Outcome("done", "", compute())
    except Exception as error:  # a defect in one cell is told, and costs no other cell
        return failed(error)


def failed(error: Exception) -> Outcome:
    """The outcome of a cell whose computation raised ``error``."""
    if isinstance(error, InfeasibleError):
        return Outcome("done", _short(str(error)), {"feasible": False})
    if isinstance(error, InputError):
        return Outcome("invalid", _short(str(error)))
    if isinstance(error, PivotGaitError):
        return Outcome("unsolved", _short(str(error)))
    return Outcome("error", _short(f"{type(error).__name__}: {error}"))


def _short(text: str) -> str:
    return text if len(text) <= REASON_LENGTH else f"{text[: REASON_LENGTH - 3]}..."
