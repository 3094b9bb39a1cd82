"""Panels of curves and points over one quantity, for the studies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plotting.style import (
    COLUMN_WIDTH,
    FINGER_COLOURS,
    LIMIT_COLOUR,
    PAGE_WIDTH,
    new_figure,
    styled,
)

COLOURS = tuple(FINGER_COLOURS.values())
"""Of curves that name no finger, in their order."""


@dataclass(frozen=True, eq=False)
class Curve(FrozenArrays):
    """One curve, or points.

    Attributes:
        label: in the legend; a finger's name gives its colour.
        x: (n,) across.
        y: (n,) up; gaps where NaN.
        style: of the line as matplotlib has it; empty for points alone.
        marker: of the points; empty for none.
    """

    label: str
    x: Array
    y: Array
    style: str = "-"
    marker: str = ""


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves over a common quantity.

    Attributes:
        title: above.
        x: label across, with its unit.
        y: label up, with its unit.
        curves: to draw.
        limit: level drawn as a limit; None for none.
        y_range: of the vertical axis; None for that of the data.
    """

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...] = field(default=())
    limit: float | None = None
    y_range: tuple[float | None, float | None] | None = None


@styled
def curve_panels(rows: Sequence[Sequence[Panel]], *, height: float = 2.1) -> Any:
    """Rows of panels of curves; those of a row share the vertical scale, one legend serves all.

    Args:
        rows: all of the same length.
        height: of a row [in].
    """
    columns = len(rows[0])
    width = COLUMN_WIDTH if columns == 1 else PAGE_WIDTH
    figure = new_figure(width, 0.5 + height * len(rows))
    every = figure.subplots(len(rows), columns, sharey="row", sharex="col", squeeze=False)
    labels = list(dict.fromkeys(c.label for row in rows for panel in row for c in panel.curves))
    colours = _colours(labels)
    handles: dict[str, Any] = {}
    for panels, axes in zip(rows, every, strict=True):
        for panel, at in zip(panels, axes, strict=True):
            for k, curve in enumerate(panel.curves):
                look: dict[str, Any] = {
                    "color": colours[curve.label],
                    "ls": curve.style or "none",
                    "ms": 3.5,
                }
                look["lw"] = max(2.2 - 0.7 * k, 0.8)  # so that curves that coincide are all seen
                drawn = at.plot(curve.x, curve.y, marker=curve.marker or None, **look)
                handles.setdefault(curve.label, drawn[0])
            _finish(at, panel, first=at is axes[0])
    _label_across(figure, rows[-1], every[-1])
    if len(labels) > 1:
        figure.legend(
            handles.values(),
            handles.keys(),
            loc="outside upper center",
            ncols=min(len(labels), 2 if columns == 1 else 5),
            frameon=False,
        )
    return figure


def _label_across(figure: Any, panels: Sequence[Panel], row: Any) -> None:
    """Label the lowest row: once for all panels where they share the quantity, so that narrow
    panels' labels do not run into one another."""
    if len(panels) > 1 and len({panel.x for panel in panels}) == 1:
        figure.supxlabel(panels[0].x, fontsize=row[0].xaxis.label.get_fontsize())
        return
    for panel, axes in zip(panels, row, strict=True):
        axes.set_xlabel(panel.x)


def _finish(axes: Any, panel: Panel, *, first: bool) -> None:
    axes.set_title(panel.title)
    if panel.limit is not None:
        axes.axhline(panel.limit, color=LIMIT_COLOUR, lw=0.9, ls=(0, (4, 2)))
    if panel.y_range is not None:
        axes.set_ylim(panel.y_range)
    if first:
        axes.set_ylabel(panel.y)


def _colours(labels: Sequence[str]) -> dict[str, str]:
    known = {label: FINGER_COLOURS[label] for label in labels if label in FINGER_COLOURS}
    others = [label for label in labels if label not in known]
    spare = [each for each in COLOURS if each not in known.values()] or list(COLOURS)
    return known | {label: spare[k % len(spare)] for k, label in enumerate(others)}
