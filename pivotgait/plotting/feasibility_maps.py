"""Maps of feasibility: what holds, by how much, and the border of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from pivotgait.plotting.parameters import parameter_label, parameter_value
from pivotgait.plotting.style import COLUMN_WIDTH, LIMIT_COLOUR, PAGE_WIDTH, new_figure, styled

if TYPE_CHECKING:  # a figure needs none of the solvers behind the records
    from pivotgait.feasibility.maps import FeasibilityMap
    from pivotgait.feasibility.shares import ShareMap

INFEASIBLE_COLOUR = "#E4E4E4"
_NO_SCENE: dict[str, Any] = {
    "facecolor": "#FFFFFF",
    "edgecolor": "#BBBBBB",
    "hatch": "////",
    "linewidth": 0.0,
}
_QUANTITIES = {
    "depth": ("room to every limit [N]", "YlGnBu"),
    "margin": ("friction that could be missing [-]", "YlGnBu"),
    "turn": ("smallest turn that lets it hold [deg]", "YlOrBr"),
}
_OWN: dict[str, Any] = {
    "marker": "D",
    "ms": 5.0,
    "mfc": "#FFFFFF",
    "mec": LIMIT_COLOUR,
    "mew": 1.1,
    "ls": "none",
}


@styled
def feasibility_maps(maps: Sequence[FeasibilityMap], *, share: ShareMap | None = None) -> Any:
    """Each map as a panel, with contours where the grasp holds and its border; then the share.

    Args:
        maps: with the same axes and quantity: slices over a third parameter.
        share: of draws that hold, in a panel of its own.
    """
    count = len(maps) + (share is not None)
    width = COLUMN_WIDTH if count == 1 else PAGE_WIDTH
    figure = new_figure(width, 3.1 if count == 1 else 2.9)
    panels = figure.subplots(1, count, sharex=True, sharey=True, squeeze=False)[0]
    name, colours = _QUANTITIES[maps[0].question.quantity]
    levels = _levels(maps)
    shading = _mappable(levels, colours)
    empty = False
    for axes, each in zip(panels, maps, strict=False):
        empty |= _draw(axes, each, levels, shading)
        axes.set_title(_title(maps, each))
    scale = figure.colorbar(shading, ax=list(panels[: len(maps)]), aspect=18)
    scale.set_label(name)
    if share is not None:
        _draw_share(figure, panels[-1], share)
    for axes in panels:
        for spine in axes.spines.values():
            spine.set_visible(True)
    for axes in panels if count < 3 else panels[[count // 2]]:  # long labels would meet
        axes.set_xlabel(parameter_label(maps[0].across.parameter).text)
    panels[0].set_ylabel(parameter_label(maps[0].up.parameter).text)
    handles = [
        Line2D([], [], color=LIMIT_COLOUR, lw=1.4, label="border of what holds"),
        Patch(facecolor=INFEASIBLE_COLOUR, label="infeasible"),
    ]
    if empty:
        handles.append(Patch(**_NO_SCENE, label="no such grasp"))
    if np.isfinite(maps[0].own).all():
        handles.insert(1, Line2D([], [], **_OWN, label="the scene's own"))
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=2 if count == 1 else len(handles),
        frameon=False,
    )
    return figure


def _draw(axes: Any, each: FeasibilityMap, levels: Any, shading: Any) -> bool:
    """Draw one map; returns whether some of its values make no scene."""
    across, up = parameter_label(each.across.parameter), parameter_label(each.up.parameter)
    scale = np.array([across.scale, up.scale])
    points = each.points * scale
    mesh = Triangulation(*points.T)
    empty = np.isnan(each.feasible)[mesh.triangles].any(axis=1)
    axes.set_facecolor(INFEASIBLE_COLOUR)
    if empty.any():
        axes.add_collection(PolyCollection(points[mesh.triangles[empty]], **_NO_SCENE))
    value = np.where(np.isfinite(each.value), each.value, np.nan)
    if each.question.quantity == "turn":
        missing = np.isnan(value)[mesh.triangles].any(axis=1)
        value = np.nan_to_num(value)
    else:
        missing = empty
        value = np.where(np.isnan(value), np.nanmin(value, initial=-1.0) - 1.0, value)
    if not missing.all():
        mesh.set_mask(missing)
        paint: dict[str, Any] = {"cmap": shading.cmap, "norm": shading.norm}
        axes.tricontourf(mesh, value, levels=levels, extend="max", **paint)
        axes.tricontour(mesh, value, levels=levels, colors="#FFFFFF", linewidths=0.4)
    lines = LineCollection(each.border * scale, color=LIMIT_COLOUR, lw=1.4, capstyle="round")
    axes.add_collection(lines)
    if np.isfinite(each.own).all():
        axes.plot(*(each.own * scale), **_OWN, zorder=5)
    axes.set_xlim(scale[0] * each.across.low, scale[0] * each.across.high)
    axes.set_ylim(scale[1] * each.up.low, scale[1] * each.up.high)
    return bool(empty.any())


def _draw_share(figure: Any, axes: Any, share: ShareMap) -> None:
    across, up = parameter_label(share.across.parameter), parameter_label(share.up.parameter)
    levels = np.linspace(0.0, 100.0, 11)
    grid = np.ma.masked_invalid(100.0 * share.share)
    filled = axes.contourf(
        across.scale * share.x, up.scale * share.y, grid, levels=levels, cmap="RdYlBu"
    )
    axes.set_title(f"share of {share.draws} draws that hold")
    figure.colorbar(filled, ax=axes, aspect=18).set_label("share of draws [%]")


def _levels(maps: Sequence[FeasibilityMap]) -> Any:
    """Round levels from the border to the largest value."""
    kept = np.concatenate([each.value[each.feasible == 1.0] for each in maps])
    kept = kept[np.isfinite(kept)]
    if not len(kept):
        return np.linspace(0.0, 1.0, 6)
    # to two digits, so that the scale reads well
    least = np.floor(100.0 * float(kept.min())) / 100.0
    low = least if maps[0].question.quantity == "margin" else 0.0
    high = float(np.quantile(kept, 0.99))
    ticks = MaxNLocator(7).tick_values(low, max(high, low + 1e-9))
    inside = [tick for tick in ticks if low < tick <= high]
    return np.array([low, *inside]) if len(inside) > 1 else np.linspace(low, high + 1e-9, 5)


def _mappable(levels: Any, colours: str) -> Any:
    cmap = colormaps[colours]
    return ScalarMappable(BoundaryNorm(levels, cmap.N, extend="max"), cmap)


def _title(maps: Sequence[FeasibilityMap], each: FeasibilityMap) -> str:
    if len(maps) == 1:
        return ""
    differing = [
        name for name in each.fixed if len({str(other.fixed.get(name)) for other in maps}) > 1
    ]
    return "\n".join(
        _removed(str(each.fixed[name]))
        if name == "removed"
        else parameter_value(name, each.fixed[name])
        for name in differing
    )


def _removed(finger: str) -> str:
    return f"without {finger}" if finger else "with all fingers"
