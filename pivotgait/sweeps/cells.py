"""The cells of a sweep, made from their number one at a time: there is no list of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod

from pivotgait.models.parameters import Value
from pivotgait.sweeps.axes import Axis


@dataclass(frozen=True)
class Cell:
    """One case of a sweep.

    Attributes:
        number: its place in the sweep, from 0.
        draw: number of the draw, 0 without distributions.
        values: parameter -> value, in the order of the axes.
    """

    number: int
    draw: int
    values: Mapping[str, Value]


@dataclass(frozen=True)
class CellSpace:
    """Every combination of the grid axes' values, and at each so many draws of the others.

    Cells are numbered in mixed radix: the draws vary fastest, then the last axis.

    Attributes:
        axes: in the study's order.
        draws: at each place of the grid; 1 without distributions.
        seed: of the draws.
    """

    axes: tuple[Axis, ...]
    draws: int
    seed: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis, then the draws."""
        return (*(axis.count for axis in self.axes), self.draws)

    @cached_property
    def count(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    def cell(self, number: int) -> Cell:
        """The cell with a number.

        Raises:
            IndexError: there is no such cell.
        """
        if not 0 <= number < self.count:
            raise IndexError(f"cell {number} of {self.count}")
        rest, draw = divmod(number, self.draws)
        values: dict[str, Value] = {}
        for axis in reversed(self.axes):
            rest, place = divmod(rest, axis.count)
            values[axis.parameter] = axis.draw(self.seed, draw) if axis.drawn else axis.value(place)
        return Cell(number, draw, {axis.parameter: values[axis.parameter] for axis in self.axes})


def cell_hash(context: str, cell: Cell, *, draw_matters: bool) -> str:
    """Name of a cell by its content: 32 hexadecimal digits.

    Args:
        context: digest of everything else that a result depends on.
        cell: whose values, not whose number, count.
        draw_matters: whether the number of the draw counts beside the values it gave.
    """
    content: dict[str, object] = {"context": context, "values": dict(sorted(cell.values.items()))}
    if draw_matters:
        content["draw"] = cell.draw
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:32]
