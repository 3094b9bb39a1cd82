"""How long planners take: the share of problems that are solved within a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import FuncFormatter, NullFormatter

from pivotgait.frozen import Array
from pivotgait.plotting.style import LIMIT_COLOUR, PAGE_WIDTH, new_figure, styled

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")


@styled
def planning_times(panels: Mapping[str, Mapping[str, Array]], *, limit_s: float) -> Any:
    """Share of problems solved over the time taken, one panel beside the other.

    Args:
        panels: title -> name of a set of problems -> (N,) time of each [s], infinite where
            unsolved; up to four sets in a panel.
        limit_s: time that a solution may take.
    """
    figure = new_figure(PAGE_WIDTH, 3.0)
    axes = figure.subplots(1, len(panels), sharex=True, sharey=True, squeeze=False)[0]
    first, last = _span([times for sets in panels.values() for times in sets.values()], limit_s)
    for axis, (title, sets) in zip(axes, panels.items(), strict=True):
        axis.axvline(limit_s, color=LIMIT_COLOUR, lw=0.9, ls=(0, (4, 2)))
        for (name, times), colour in zip(sets.items(), _COLOURS, strict=False):
            solved = np.sort(times[np.isfinite(times)])
            across = np.concatenate(([first], solved, [last]))
            share = np.arange(len(solved) + 1) / len(times)
            up = 100.0 * np.append(share, share[-1])
            axis.step(across, up, where="post", color=colour, label=name)
        axis.set_xscale("log")
        axis.set_xlim(first, last)
        axis.xaxis.set_major_formatter(FuncFormatter(lambda time, _: f"{time:g}"))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_ylim(0.0, 102.0)
        axis.set_xlabel("time [s]")
        axis.set_title(title)
        place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.3), "ncols": 1}
        axis.legend(**place, frameon=False, columnspacing=1.2, handlelength=1.6)
        beside = {"xytext": (-3, 0), "textcoords": "offset points", "rotation": 90}
        axis.annotate("limit", (limit_s, 4.0), **beside, ha="right", va="bottom")
    axes[0].set_ylabel("problems solved [%]")
    return figure


def _span(sets: Sequence[Array], limit_s: float) -> tuple[float, float]:
    """Ends of the time axis."""
    solved = np.concatenate([times[np.isfinite(times)] for times in sets])
    first = float(np.min(solved, initial=limit_s))
    last = float(np.max(solved, initial=limit_s))
    return 0.7 * first, 1.5 * last
