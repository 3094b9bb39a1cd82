"""How large an error each phase of a gait absorbs, from a verdict on its feasibility."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from pivotgait.plotting.style import LIMIT_COLOUR, PAGE_WIDTH, new_figure, styled

if TYPE_CHECKING:  # a figure needs none of the solvers behind the record
    from pivotgait.feasibility.gait_margins import GaitMargins

BAR_COLOUR, LEAST_COLOUR = "#0072B2", "#D55E00"
"""The phase with the least of a margin is orange."""


class _Panel(NamedTuple):
    key: str
    label: str
    scale: float


_PANELS = (
    _Panel("friction_drop", "friction\nlower by [%]", 100.0),
    _Panel("mass_increase", "mass\nhigher by [%]", 100.0),
    _Panel("sensing_share", "sensing error,\nof 25 % and 30° [%]", 100.0),
    _Panel("lift_off_N", "tip's force\nreserve [N]", 1.0),
    _Panel("wrench_ball_N", "any wrench,\nat the end [N]", 1.0),
)


@styled
def robust_margins(margins: GaitMargins) -> Any:
    """Bars of the largest error that each phase absorbs, one panel for each kind of error.

    At 0 the grasp is on the edge. A phase that cannot be done has a bar below 0 for the friction
    it lacks and none for the rest. A figure of page width.

    Args:
        margins: of a verdict.
    """
    phases = list(margins.by_phase)
    figure = new_figure(PAGE_WIDTH, 1.0 + 0.22 * len(phases))
    every = figure.subplots(1, len(_PANELS), sharey=True)
    for axes, panel in zip(every, _PANELS, strict=True):
        _draw(axes, panel, margins.by_phase)
    every[0].set_yticks(range(len(phases)), phases)
    every[0].invert_yaxis()
    return figure


def _draw(axes: Any, panel: _Panel, by_phase: Mapping[str, Mapping[str, float | None]]) -> None:
    values = [values[panel.key] for values in by_phase.values()]
    known = [panel.scale * value for value in values if value is not None]
    span = max([abs(value) for value in known], default=1.0) or 1.0
    for row, value in enumerate(values):
        if value is None:
            axes.annotate("–", (0.0, row), ha="left", va="center", fontsize=7)
            continue
        size = panel.scale * value
        colour = LEAST_COLOUR if size == min(known) else BAR_COLOUR
        axes.barh(row, size, height=0.6, color=colour)
        beyond = (max(size, 0.0) + 0.03 * span, row)
        axes.annotate(_shown(size), beyond, ha="left", va="center", fontsize=7)
    axes.axvline(0.0, color=LIMIT_COLOUR, lw=0.8)
    axes.set_xlim(1.15 * min([0.0, *known]), 1.45 * span)
    axes.set_xlabel(panel.label)
    axes.tick_params(axis="y", length=0)


def _shown(size: float) -> str:
    return (f"{size:.0f}" if abs(size) >= 10.0 else f"{size:.2g}").replace("-", "−")
