"""What figures of a run share: its time axis, its curves, and limits with their names."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.labels import EndLabel
from pivotgait.plotting.style import LIMIT_COLOUR, mixed
from pivotgait.plotting.timeline import shade_phases
from pivotgait.validation.record_reading import RecordedMotion

_PALE = 0.6
"""Share of white in the colour of what was planned."""


def shade_run(axes: Any, plan: GaitPlan, motion: RecordedMotion, *, named: bool = True) -> None:
    """Shade the plan's phases and the final hold of its run."""
    shade_phases(axes, plan, named=named, end=float(motion.series.time[-1]))


def since_start(motion: RecordedMotion, values: Array) -> tuple[Array, Array]:
    """Times (M,) [s] from the plan's start on, and ``values`` (N, ...) there."""
    begun = motion.series.time >= 0.0
    return motion.series.time[begun], values[begun]


def draw_pair(
    axes: Any, motion: RecordedMotion, planned: Array, measured: Array, colour: str
) -> list[EndLabel]:
    """Planned values (N,) as a broad pale line, measured ones (N,) as a thin one upon it."""
    pale = mixed(colour, _PALE)
    axes.plot(*since_start(motion, planned), color=pale, lw=2.8, label="planned")
    axes.plot(*since_start(motion, measured), color=colour, lw=0.8, label="measured")
    named = (("planned, pale", planned), ("measured", measured))
    ends = ((text, values[np.isfinite(values)]) for text, values in named)
    return [EndLabel(text, float(known[-1]), colour) for text, known in ends if known.size]


def draw_limit(axes: Any, limit: float, text: str) -> EndLabel:
    """Dash a limit across ``axes``, which must already reach it."""
    axes.axhline(limit, color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    return EndLabel(text, limit, LIMIT_COLOUR)
