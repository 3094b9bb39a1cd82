"""A sweep's results: maps over two parameters with slices over a third, lines over one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plotting.feasibility_maps import INFEASIBLE_COLOUR
from pivotgait.plotting.parameters import parameter_label, parameter_value
from pivotgait.plotting.style import (
    COLUMN_WIDTH,
    LIMIT_COLOUR,
    PAGE_WIDTH,
    PIVOT_COLOUR,
    new_figure,
    styled,
)

LINE_COLOUR = "#0072B2"
Values = tuple[float | str, ...]


@dataclass(frozen=True, eq=False)
class GridMap:
    """One quantity over two parameters.

    Attributes:
        across: parameter of the columns.
        up: parameter of the rows.
        x: (n,) values across; numbers or names.
        y: (m,) values up.
        slices: (k,) values of a third parameter, one panel each; one empty text without it.
        sliced: the third parameter; empty without it.
        value: (k, m, n); NaN where there is none.
        share: (k, m, n) of the cells that are feasible.
        label: of the quantity, with its unit.
        top: largest value of the scale; None for that of the data.
    """

    across: str
    up: str
    x: Values
    y: Values
    slices: Values
    sliced: str
    value: Array
    share: Array
    label: str
    top: float | None = None


@dataclass(frozen=True, eq=False)
class GridLines:
    """A quantity over one parameter, with its interval.

    Attributes:
        parameter: across.
        x: (n,) values.
        y: (n,) of the quantity.
        low: (n,) lower end of the interval.
        high: (n,) its upper end.
        label: of the quantity, with its unit.
        range: of the vertical axis; None for that of the data.
    """

    parameter: str
    x: Values
    y: Array
    low: Array
    high: Array
    label: str
    range: tuple[float, float] | None = None


@styled
def grid_maps(grid: GridMap) -> Any:
    """Coloured cells for each slice; grey where infeasible, a line where half of them are."""
    count = len(grid.slices)
    columns = min(count, 4)
    rows = -(-count // columns)
    width = COLUMN_WIDTH if count == 1 else PAGE_WIDTH
    figure = new_figure(width, 2.7 if count == 1 else 0.5 + 2.1 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    known = grid.value[np.isfinite(grid.value)]
    low = min(float(known.min()), 0.0) if known.size else 0.0
    # a few large values would take all the colours
    high = grid.top or (float(np.quantile(known, 0.97)) if known.size else 1.0)
    beyond = known.size > 0 and bool(known.max() > high)
    scale = {"vmin": low, "vmax": max(high, low + 1e-9), "cmap": "YlGnBu"}
    x, y = _numbers(grid.across, grid.x), _numbers(grid.up, grid.y)
    for k, axes in enumerate(panels.ravel()):
        if k >= count:
            axes.axis("off")
            continue
        axes.set_facecolor(INFEASIBLE_COLOUR)
        shown = np.ma.masked_invalid(grid.value[k])
        mesh = axes.pcolormesh(x, y, shown, shading="nearest", rasterized=True, **scale)
        share = np.nan_to_num(grid.share[k])
        if min(share.shape) > 1 and share.min() < 0.5 < share.max():
            axes.contour(x, y, share, levels=[0.5], colors=LIMIT_COLOUR, linewidths=1.2)
        if grid.sliced:
            axes.set_title(parameter_value(grid.sliced, grid.slices[k]))
        _ticks(axes, grid)
    figure.supxlabel(parameter_label(grid.across).text, fontsize="medium")
    figure.supylabel(parameter_label(grid.up).text, fontsize="medium")
    bar = figure.colorbar(mesh, ax=panels, aspect=18, extend="max" if beyond else "neither")
    bar.set_label(grid.label)
    return figure


@styled
def grid_lines(lines: GridLines) -> Any:
    """A curve over one parameter, with the interval of each value as a band."""
    figure = new_figure(COLUMN_WIDTH, 2.2)
    axes = figure.subplots()
    x = _numbers(lines.parameter, lines.x)
    axes.fill_between(x, lines.low, lines.high, color=LINE_COLOUR, alpha=0.2, lw=0)
    axes.plot(x, lines.y, color=LINE_COLOUR, marker="o", ms=3.0)
    axes.axhline(0.0, color=PIVOT_COLOUR, lw=0.6)
    axes.set_ylim(lines.range)
    axes.set_xlabel(parameter_label(lines.parameter).text)
    axes.set_ylabel(lines.label)
    if any(isinstance(each, str) for each in lines.x):
        axes.set_xticks(x, [str(each) for each in lines.x], rotation=30)
    return figure


def _numbers(parameter: str, values: Values) -> Array:
    if any(isinstance(each, str) for each in values):
        return np.arange(len(values), dtype=float)
    return parameter_label(parameter).scale * np.array(values, dtype=float)


def _ticks(axes: Any, grid: GridMap) -> None:
    for values, place in ((grid.x, axes.set_xticks), (grid.y, axes.set_yticks)):
        if any(isinstance(each, str) for each in values):
            place(range(len(values)), [str(each) for each in values])
