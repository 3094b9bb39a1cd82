"""Normal forces of a gait over time, between their bounds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts.cone import split_force
from pivotgait.plans.plan import PIVOT, GaitPlan
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    contact_names,
    contact_strokes,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import Span, shade_phases, spans

Array = NDArray[np.float64]


@styled
def normal_forces(plan: GaitPlan) -> Any:
    """Normal force of every contact over the gait, the pivot's in a panel of its own.

    Bounds of a phase are dashed. A figure of page width.
    """
    figure = new_figure(PAGE_WIDTH, 3.2)
    fingers, pivot = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    draw_finger_forces(fingers, plan)
    draw_pivot_force(pivot, plan)
    pivot.set_xlabel("time [s]")
    return figure


def draw_finger_forces(axes: Any, plan: GaitPlan, *, named: bool = True) -> None:
    """Normal forces of the fingers [N] on ``axes``."""
    _draw(axes, plan, [n for n in contact_names(plan) if n != PIVOT], named=named)
    axes.set_ylabel("finger normal\nforce [N]")


def draw_pivot_force(axes: Any, plan: GaitPlan, *, named: bool = False) -> None:
    """Normal force of the table on the tip [N] on ``axes``."""
    _draw(axes, plan, [PIVOT], named=named)
    axes.set_ylabel("pivot normal\nforce [N]")


def _draw(axes: Any, plan: GaitPlan, names: list[str], *, named: bool) -> None:
    shade_phases(axes, plan, named=named)
    colours, strokes = contact_colours(plan), contact_strokes(plan)
    labels, largest = [], 0.0
    for name in names:
        for span, normal in _normal_forces(plan, name):
            axes.plot(span.time, normal, label=name, **strokes[name])
            largest = max(largest, float(normal.max()))
            last = EndLabel(name, float(normal[-1]), colours[name])
        labels += [last] if any(name in phase.contacts for phase in plan.phases) else []
    axes.set_ylim(0.0, 1.25 * largest or 1.0)
    labels += draw_bounds(axes, plan, names)
    label_right(axes, labels)


def _normal_forces(plan: GaitPlan, name: str) -> Iterator[tuple[Span, Array]]:
    for span in spans(plan):
        if name in span.phase.contacts:
            track = span.phase.contacts[name]
            normal, _ = split_force(track.force, track.world_normal(span.phase.tool))
            yield span, normal


def draw_bounds(axes: Any, plan: GaitPlan, names: Sequence[str]) -> list[EndLabel]:
    """Dash the bounds of ``names``; one out of sight is told by its label at the top.

    Returns:
        Their labels, for :func:`label_right`.
    """
    _, top = axes.get_ylim()
    shown: dict[tuple[str, float], None] = {}
    for span in spans(plan):
        for name in names:
            if name not in span.phase.contacts:
                continue
            track = span.phase.contacts[name]
            for word, bound in (("min", track.normal_min), ("max", track.normal_max)):
                if bound > 0.0:
                    shown[word, bound] = None
                    if bound <= top:
                        ends = (span.start, span.end)
                        axes.plot(ends, (bound, bound), color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    return [
        EndLabel(f"{word} {bound:g} N{' ↑' if bound > top else ''}", min(bound, top), LIMIT_COLOUR)
        for word, bound in shown
    ]
