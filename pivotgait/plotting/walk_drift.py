"""Fingers that walk: how drift and slip grow from gait to gait, one line for each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plotting.style import PAGE_WIDTH, new_figure, styled

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
_PANELS = (
    ("tip_mm", "tip along the table [mm]"),
    ("turn_deg", "turn from the plan [deg]"),
    ("finger_mm", "largest finger slip [mm]"),
)


@dataclass(frozen=True, eq=False)
class Walk(FrozenArrays):
    """One run, at the end of each addition that it came to; a shorter one was broken off.

    Attributes:
        way: of running, for the legend.
        perturbed: whether world and sensors differed from the plan.
        tip_mm: (G,) of the tip along the table since the start.
        turn_deg: (G,) of the tool from what was asked at that moment.
        finger_mm: (G,) largest of a holding finger along the tool's surface.
    """

    way: str
    perturbed: bool
    tip_mm: Array
    turn_deg: Array
    finger_mm: Array


@styled
def walk_drift(walks: Sequence[Walk]) -> Any:
    """Three panels over the number of gaits done; nominal runs thick, perturbed ones thin.

    Args:
        walks: of up to four ways of running. Gait 0 ends with the first addition.
    """
    figure = new_figure(PAGE_WIDTH, 2.6)
    axes = figure.subplots(1, len(_PANELS), sharex=True)
    ways = list(dict.fromkeys(each.way for each in walks))
    for axis, (name, title) in zip(axes, _PANELS, strict=True):
        for each in sorted(walks, key=lambda walk: not walk.perturbed):
            values = getattr(each, name)
            colour = _COLOURS[ways.index(each.way)]
            weight = {"lw": 0.6, "alpha": 0.5} if each.perturbed else {"lw": 1.8, "marker": "o"}
            label = None if each.perturbed else each.way
            axis.plot(np.arange(len(values)), values, color=colour, ms=3, label=label, **weight)
        axis.set_title(title)
        axis.set_xlabel("gaits done")
        axis.set_ylim(bottom=0.0)
        axis.xaxis.get_major_locator().set_params(integer=True)
    axes[0].legend(frameon=False, loc="best")
    return figure
