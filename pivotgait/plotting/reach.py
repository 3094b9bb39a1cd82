"""Where a mounted hand reaches: maps over tilt and pedestal, and over the tool's place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator, MultipleLocator

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plotting.style import COLUMN_WIDTH, LIMIT_COLOUR, new_figure, styled

_NONE = "#EDEDED"
_OWN = {
    "marker": "D",
    "ms": 5.0,
    "mfc": "#FFFFFF",
    "mec": LIMIT_COLOUR,
    "mew": 1.1,
    "ls": "none",
    "zorder": 5,
}


@dataclass(frozen=True, eq=False)
class MountingMap(FrozenArrays):
    """Postures of one scene over the tilt (n columns) and the pedestal (m rows).

    Attributes:
        scene: its name.
        tilt_deg: (n,) ascending.
        height_mm: (m,) ascending.
        share: (m, n) of the starts that end in postures.
        stroke_mm: (m, n) farthest that one of them keeps J3 from its ends; NaN without any.
        singular_value_mm: (m, n) of the best conditioned; NaN without any.
    """

    scene: str
    tilt_deg: Array
    height_mm: Array
    share: Array
    stroke_mm: Array
    singular_value_mm: Array


@dataclass(frozen=True, eq=False)
class PlaceMap(FrozenArrays):
    """Postures of one scene over the tool's place: radius (n columns) and yaw (m rows).

    Attributes:
        scene: its name.
        radius: (n,) from the arm's axis to the grasp [m], ascending.
        yaw_deg: (m,) of the tool, 0 with the tip away from the arm, ascending.
        share: (m, n) of the postures that the arm carries there.
        own: the scene's own radius [m] and yaw [deg].
    """

    scene: str
    radius: Array
    yaw_deg: Array
    share: Array
    own: tuple[float, float]


@styled
def mounting_maps(
    maps: Sequence[MountingMap], *, own: tuple[float, float], tilt_max_deg: float
) -> Any:
    """From above: share of starts that end in postures, room of J3, conditioning of the best.

    Args:
        maps: one scene per column.
        own: the chosen tilt [deg] and height [mm].
        tilt_max_deg: beyond it the last joint of the arm carries too much inertia.
    """
    figure = new_figure(COLUMN_WIDTH, 5.0)
    rows = [
        ("share of starts [%]", "YlGnBu", [100.0 * each.share for each in maps]),
        ("J3 from its ends [mm]", "YlGn", [each.stroke_mm for each in maps]),
        ("best $\\sigma_{\\min}(H)$ [mm]", "YlOrBr", [each.singular_value_mm for each in maps]),
    ]
    axes = figure.subplots(len(rows), len(maps), sharex=True, sharey=True, squeeze=False)
    for panels, (name, colours, grids) in zip(axes, rows, strict=True):
        shown = [np.ma.masked_where(~(g > 0.0), g) for g in grids]
        top = _ceiling(max((float(g.max()) for g in shown if g.count()), default=1.0))
        for axis, each, grid in zip(panels, maps, shown, strict=True):
            mesh = _cells(axis, each.tilt_deg, each.height_mm, grid, colours, top)
            limit = axis.axvline(tilt_max_deg, color=LIMIT_COLOUR, lw=0.9, ls=(0, (4, 2)))
            axis.plot(*own, **_OWN)
        bar = figure.colorbar(mesh, ax=panels, aspect=14, pad=0.02)
        bar.set_label(name)
        bar.locator = MaxNLocator(4)
        bar.update_ticks()
    for column, each in enumerate(maps):
        axes[0, column].set_title(each.scene)
        axes[-1, column].set_xlabel("tilt [deg]")
        axes[-1, column].xaxis.set_major_locator(MultipleLocator(15))
    for axis in axes[:, 0]:
        axis.set_ylabel("pedestal [mm]")
    _legend(figure, axes[0, 0], "chosen", "no posture", {"J4's limit of inertia": limit})
    return figure


@styled
def place_maps(maps: Sequence[PlaceMap]) -> Any:
    """Share of the postures found that the arm carries to another place of the tool.

    Args:
        maps: one scene per column.
    """
    figure = new_figure(COLUMN_WIDTH, 2.5)
    axes = figure.subplots(1, len(maps), sharex=True, sharey=True, squeeze=False)[0]
    for axis, each in zip(axes, maps, strict=True):
        grid = np.ma.masked_equal(100.0 * each.share, 0.0)
        mesh = _cells(axis, each.radius, each.yaw_deg, grid, "YlGnBu", 100.0)
        axis.plot(*each.own, **_OWN)
        axis.set_title(each.scene)
        axis.set_xlabel("grasp from J1 [m]")
        axis.set_yticks([-180, -90, 0, 90, 180])
        axis.set_ylim(-180, 180)
    axes[0].set_ylabel("tool's yaw [deg]")
    bar = figure.colorbar(mesh, ax=axes, aspect=18, pad=0.02)
    bar.set_label("share of postures [%]")
    _legend(figure, axes[0], "scene's own place", "out of reach")
    return figure


def _cells(axis: Any, across: Array, up: Array, grid: Any, colours: str, top: float) -> Any:
    """A cell for each value; those that are masked stay grey."""
    axis.set_facecolor(_NONE)
    mesh = axis.pcolormesh(across, up, grid, cmap=colours, vmin=0.0, vmax=top, shading="nearest")
    mesh.set_rasterized(True)
    for side in ("top", "right"):
        axis.spines[side].set_visible(True)
    return mesh


def _ceiling(value: float) -> float:
    """The next round number, a few of which lie in every power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 6.0, 8.0, 10.0])
    return float(power * steps[np.argmax(steps >= value / power - 1e-9)])


def _legend(
    figure: Any, axis: Any, own: str, none: str, others: Mapping[str, Any] | None = None
) -> None:
    marker = axis.plot([], [], **_OWN)[0]
    patch = axis.plot([], [], "s", color=_NONE, ms=7, mec="#B0B0B0", mew=0.6)[0]
    entries = {own: marker, none: patch, **(others or {})}
    place = {"loc": "outside lower left", "ncols": len(entries), "frameon": False}
    spaces = {"handletextpad": 0.4, "handlelength": 1.6, "columnspacing": 1.2}
    figure.legend(list(entries.values()), list(entries), **place, **spaces)
