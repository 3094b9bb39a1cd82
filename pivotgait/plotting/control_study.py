"""Control laws side by side: where each holds the tool, and how it presses when a finger comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plotting.style import FINGER_COLOURS, LIMIT_COLOUR, PAGE_WIDTH, new_figure, styled

_PASSED = "#009E73"
_FAILED: Mapping[str, str] = {
    "slip": "#D55E00",
    "loss": "#E69F00",
    "roll-out": "#CC79A7",
    "limit": "#0072B2",
    "collision": "#56B4E9",
    "divergence": "#000000",
}


@dataclass(frozen=True, eq=False)
class OutcomeMap(FrozenArrays):
    """Runs of one way over two errors.

    Attributes:
        title: of the way.
        width_mm: (m,) error of the handle's width.
        friction: (n,) true friction over the planned one.
        failure: n rows of m classes of failure, empty where the run passed.
        force_rms_N: (n, m) larger of the RMS errors of holding and of loading fingers.
    """

    title: str
    width_mm: Array
    friction: Array
    failure: Sequence[Sequence[str]]
    force_rms_N: Array


@dataclass(frozen=True, eq=False)
class PressingFingers(FrozenArrays):
    """Normal forces of one run while a finger is added.

    Attributes:
        title: of the run.
        time_s: (N,) since the addition's start.
        planned_N: finger -> (N,).
        measured_N: finger -> (N,).
    """

    title: str
    time_s: Array
    planned_N: Mapping[str, Array]
    measured_N: Mapping[str, Array]


@styled
def outcome_maps(maps: Sequence[OutcomeMap]) -> Any:
    """One map for each way: colour tells how the run ended, the number its force error [N]."""
    figure = new_figure(PAGE_WIDTH, 2.3)
    axes = figure.subplots(1, len(maps), sharey=True, squeeze=False)[0]
    seen: dict[str, str] = {}
    for axis, each in zip(axes, maps, strict=True):
        for row, failures in enumerate(each.failure):
            for column, failure in enumerate(failures):
                colour = _FAILED.get(failure, "#777777") if failure else _PASSED
                seen[failure or "passed"] = colour
                place = (column - 0.5, row - 0.5)
                axis.add_patch(_tile(place, colour, full=not failure))
                force = each.force_rms_N[row, column]
                said = f"{force:.2f}" if force < 9.95 else f"{force:.0f}"
                axis.text(column, row, said, ha="center", va="center", fontsize=6)
        axis.set_xlim(-0.5, len(each.width_mm) - 0.5)
        axis.set_ylim(-0.5, len(each.friction) - 0.5)
        axis.set_xticks(
            range(len(each.width_mm)), [f"{value:+g}" if value else "0" for value in each.width_mm]
        )
        axis.set_yticks(range(len(each.friction)), [f"{value:g}" for value in each.friction])
        axis.set_title(each.title)
    axes[0].set_ylabel("true friction / planned")
    figure.supxlabel(
        "error of the handle's width [mm]; numbers: RMS error of normal force [N]", fontsize=8
    )
    handles = [_tile((0, 0), colour, full=name == "passed") for name, colour in seen.items()]
    figure.legend(handles, list(seen), loc="outside upper center", ncols=len(seen), frameon=False)
    return figure


def _tile(place: tuple[float, float], colour: str, *, full: bool) -> Any:
    from matplotlib.patches import Rectangle

    hatch = None if full else "///"
    return Rectangle(
        place, 1.0, 1.0, facecolor=colour, alpha=0.45, edgecolor="white", lw=1.0, hatch=hatch
    )


@styled
def pressing_fingers(rows: Sequence[Sequence[PressingFingers]]) -> Any:
    """Normal forces while a finger is added: one column for each way, one row for each world."""
    figure = new_figure(PAGE_WIDTH, 0.6 + 1.35 * len(rows))
    axes = figure.subplots(len(rows), len(rows[0]), sharex=True, sharey="row", squeeze=False)
    for line, runs in zip(axes, rows, strict=True):
        for axis, run in zip(line, runs, strict=True):
            for name, force in run.measured_N.items():
                axis.plot(run.time_s, force, color=FINGER_COLOURS.get(name), lw=1.0, label=name)
                planned = run.planned_N[name]
                axis.plot(run.time_s, planned, color=LIMIT_COLOUR, lw=0.6, ls=(0, (3, 2)))
            axis.set_title(run.title)
            axis.set_ylim(bottom=0.0)
        line[0].set_ylabel("normal force [N]")
        top = max(float(np.max(f, initial=0.1)) for run in runs for f in run.measured_N.values())
        line[0].set_ylim(0.0, 1.05 * top)
    figure.supxlabel("time since the addition's start [s]; dashed: planned", fontsize=8)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure
