"""Which figures show a sweep: maps over its two longest axes, lines over each axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plotting.parameters import parameter_words
from pivotgait.plotting.study_maps import GridLines, GridMap, grid_lines, grid_maps
from pivotgait.sweeps.axes import Axis
from pivotgait.sweeps.study_config import Compute
from pivotgait.sweeps.study_results import StudyResults
from pivotgait.validation.wilson import wilson_interval

QUANTITIES: dict[Compute, dict[str, str]] = {
    "static": {"depth_N": "room to every limit [N]"},
    "removal": {
        "reorientation_deg": "turn of the removal [deg]",
        "friction_margin": "smallest friction margin [-]",
    },
    "plan": {
        "friction_margin": "smallest friction margin [-]",
        "reorientation_deg": "largest turn of a removal [deg]",
    },
    "trials": {"friction_margin": "smallest friction margin of the plan [-]"},
}
"""Columns that are mapped, with label and unit."""
SLICES_MAX = 4
QUINTILES = 5


@dataclass(frozen=True, eq=False)
class StudyFigure:
    """A figure with its words.

    Attributes:
        name: of its files.
        figure: drawn.
        alt: what it shows.
        caption: what to see in it.
    """

    name: str
    figure: Any
    alt: str
    caption: str


@dataclass(frozen=True, eq=False)
class AxisShare:
    """Share of feasible cells at each value of an axis.

    Attributes:
        parameter: of the axis.
        values: its values; of a distribution the middles of its quintiles.
        feasible: (n,) feasible cells.
        count: (n,) cells that are done.
        drawn: whether the values are quintiles of draws.
    """

    parameter: str
    values: tuple[float | str, ...]
    feasible: Array
    count: Array
    drawn: bool

    @property
    def interval(self) -> Array:
        """(n, 2) Wilson intervals of the share, 95 %."""
        pairs = zip(self.feasible.tolist(), self.count.tolist(), strict=True)
        return np.array([wilson_interval(int(a), int(n)) for a, n in pairs])


def study_figures(results: StudyResults) -> Iterator[StudyFigure]:
    """The figures of a sweep, the one that tells most first."""
    many = [axis for axis in results.grid_axes if axis.count > 1]
    if len(many) > 1:
        yield from _maps(results, many)
    else:
        yield from _quantities(results)
    for each in axis_shares(results):
        share = 100.0 * each.feasible / np.maximum(each.count, 1.0)
        if np.ptp(share) == 0.0:
            continue  # the table says so
        drawn = results.cells.draws > 1
        low, high = 100.0 * each.interval.T if drawn else (share, share)
        label = "feasible cells [%]"
        lines = GridLines(each.parameter, each.values, share, low, high, label, (-3.0, 103.0))
        of = "quintiles of the draws of " if each.drawn else ""
        words = parameter_words(each.parameter)
        band = "; the band is the 95 % interval (Wilson)" if drawn else ""
        yield StudyFigure(
            f"share_{_file(each.parameter)}",
            grid_lines(lines),
            f"Share of feasible cells over {of}{words}.",
            f"Share of feasible cells over {of}{words}, all other parameters taken together{band}.",
        )


def axis_shares(results: StudyResults) -> Iterator[AxisShare]:
    """The share of feasible cells along each axis with more than one value."""
    feasible = results.column("feasible")
    for place, axis in enumerate(results.grid_axes):
        if axis.count > 1:
            aside = tuple(k for k in range(feasible.ndim) if k != place)
            values = tuple(axis.value(k) for k in range(axis.count))
            count = np.sum(~np.isnan(feasible), axis=aside).astype(float)
            yield AxisShare(axis.parameter, values, np.nansum(feasible, axis=aside), count, False)
    for axis in results.drawn_axes:
        drawn = results.column(axis.parameter)
        known = ~np.isnan(feasible)
        if known.sum() < QUINTILES:
            continue
        edges = np.quantile(drawn[known], np.linspace(0.0, 1.0, QUINTILES + 1))
        part = np.clip(np.searchsorted(edges, drawn[known], side="right") - 1, 0, QUINTILES - 1)
        count = np.bincount(part, minlength=QUINTILES).astype(float)
        held = np.bincount(part, weights=feasible[known], minlength=QUINTILES).astype(float)
        middles = tuple((0.5 * (edges[1:] + edges[:-1])).tolist())
        yield AxisShare(axis.parameter, middles, held, count, True)


def _quantities(results: StudyResults) -> Iterator[StudyFigure]:
    """Each quantity over the one axis of the grid: its median and nine tenths of its draws."""
    for axis in results.grid_axes:
        for name, label in QUANTITIES[results.config.compute].items():
            value = results.column(name).reshape(axis.count, -1)
            if axis.count < 2 or not np.isfinite(value).any(axis=1).all():
                continue
            low, middle, high = np.nanquantile(value, (0.05, 0.5, 0.95), axis=1)
            values = tuple(axis.value(k) for k in range(axis.count))
            words = f"{label.rpartition(' [')[0]} over {parameter_words(axis.parameter)}"
            yield StudyFigure(
                f"line_{name}",
                grid_lines(GridLines(axis.parameter, values, middle, low, high, label)),
                f"{words.capitalize()}.",
                f"{words.capitalize()}: median, and the band that holds nine tenths of the cells.",
            )


def _maps(results: StudyResults, many: list[Axis]) -> Iterator[StudyFigure]:
    order = sorted(many, key=lambda axis: (axis.named, -axis.count))
    up, across, *rest = order
    sliced = rest[0] if rest else None
    wanted = [across, up] if sliced is None else [sliced, up, across]
    feasible = results.column("feasible")
    share, picks = _over(results, wanted, feasible)
    label = "feasible cells [%]"
    own = (
        ""
        if len(rest) < 2
        else f" Averaged over {', '.join(parameter_words(a.parameter) for a in rest[1:])}."
    )
    quantities = {**QUANTITIES[results.config.compute]}
    if results.config.compute == "trials":
        passed = results.column("passed") / results.column("trials")
        rate, _ = _over(results, wanted, passed)
        yield _map(across, up, sliced, picks, 100.0 * rate, share, "trials passed [%]", own, 100.0)
    for name, words in quantities.items():
        value, _ = _over(results, wanted, np.where(feasible == 1.0, results.column(name), np.nan))
        yield _map(across, up, sliced, picks, value, share, words, own, name=name)
    if results.cells.draws > 1 or rest[1:]:
        yield _map(across, up, sliced, picks, 100.0 * share, share, label, own, 100.0)


def _map(
    across: Axis,
    up: Axis,
    sliced: Axis | None,
    picks: list[int],
    value: Array,
    share: Array,
    label: str,
    more: str,
    top: float | None = None,
    *,
    name: str = "share",
) -> StudyFigure:
    grid = GridMap(
        across=across.parameter,
        up=up.parameter,
        x=tuple(across.value(k) for k in range(across.count)),
        y=tuple(up.value(k) for k in range(up.count)),
        slices=tuple(sliced.value(k) for k in picks) if sliced else ("",),
        sliced=sliced.parameter if sliced else "",
        value=value,
        share=share,
        label=label,
        top=top,
    )
    words = label.rpartition(" [")[0]
    where = f"{parameter_words(across.parameter)} and {parameter_words(up.parameter)}"
    slices = ""
    if sliced:
        slices = f", one panel for each of {len(picks)} values of "
        slices += parameter_words(sliced.parameter)
    caption = f"{words.capitalize()} over {where}{slices}. Grey: infeasible or not computed; the "
    caption += f"line is where half of the cells are feasible.{more}"
    return StudyFigure(f"map_{name}", grid_maps(grid), f"Map of {words} over {where}.", caption)


def _over(results: StudyResults, wanted: list[Axis], values: Array) -> tuple[Array, list[int]]:
    """(k, m, n) means over all axes but those wanted, and the places of the slices taken."""
    axes = list(results.grid_axes)
    places = [axes.index(axis) for axis in wanted]
    aside = tuple(k for k in range(values.ndim) if k not in places)
    known = np.sum(~np.isnan(values), axis=aside)
    total = np.nansum(values, axis=aside)
    mean = np.where(known > 0, total / np.maximum(known, 1), np.nan)
    kept = sorted(places)
    mean = np.transpose(mean, [kept.index(place) for place in places])
    if len(wanted) == 2:
        return mean.T[None], [0]
    count = wanted[0].count
    picks = np.unique(np.linspace(0, count - 1, min(count, SLICES_MAX)).round().astype(int))
    return mean[picks], picks.tolist()


def _file(parameter: str) -> str:
    return "".join(each if each.isalnum() else "_" for each in parameter.replace("*", "all"))
