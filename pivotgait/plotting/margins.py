"""Friction margins of a gait over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.margins import Margin, gait_margins, smallest_margin
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    contact_strokes,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import shade_phases, spans


@styled
def margins(plan: GaitPlan) -> Any:
    """Friction margin ``1 - |f_t| / (mu f_n)`` of every contact over the gait.

    The contact slips at 0; the smallest margin is marked. A figure of page width.
    """
    figure = new_figure(PAGE_WIDTH, 2.4)
    axes = figure.subplots()
    draw_margins(axes, plan)
    axes.set_xlabel("time [s]")
    return figure


def draw_margins(axes: Any, plan: GaitPlan, *, named: bool = True) -> None:
    """Friction margins of all contacts on ``axes``."""
    shade_phases(axes, plan, named=named)
    colours, strokes = contact_colours(plan), contact_strokes(plan)
    ends: dict[str, EndLabel] = {}
    starts = {}
    for span, phase in zip(spans(plan), gait_margins(plan), strict=True):
        starts[phase.phase] = span.start
        for name, contact in phase.contacts.items():
            axes.plot(span.time, contact.friction, **strokes[name])
            known = contact.friction[np.isfinite(contact.friction)]
            if known.size:
                ends[name] = EndLabel(name, float(known[-1]), colours[name])
    least = smallest_margin(plan, ["friction"])
    axes.axhline(0.0, color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    axes.set_ylim(min(-0.04, 1.1 * least.value if least else 0.0), 1.04)
    axes.set_ylabel("friction\nmargin [-]")
    if least:
        _mark(axes, least, starts[least.phase] + least.time_s, colours[least.contact])
    label_right(axes, [*ends.values(), EndLabel("slips ≤ 0", 0.0, LIMIT_COLOUR)])


def _mark(axes: Any, least: Margin, time: float, colour: str) -> None:
    _, last = axes.get_xlim()
    early = time < 0.6 * last
    axes.plot(time, least.value, "o", ms=4, color=colour, clip_on=False)
    axes.annotate(
        f"least: {round(least.value, 3) + 0.0:.3f}, {least.contact}, {time:.2f} s".replace(
            "-", "−"
        ),
        (time, least.value),
        xytext=(6 if early else -6, 7),
        textcoords="offset points",
        ha="left" if early else "right",
        fontsize=7,
        color=colour,
        bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 0.8},
    )
