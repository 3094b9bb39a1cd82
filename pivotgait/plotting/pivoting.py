"""What pivoting buys: maps over friction and contact place, lines, and a handle's section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from pivotgait.plotting.style import (
    FINGER_COLOURS,
    LIMIT_COLOUR,
    PAGE_WIDTH,
    new_figure,
    styled,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_QUIET = "#707070"
_HALO = withStroke(linewidth=1.8, foreground="#FFFFFFD0")  # labels lie on dark cells too
_SHARE_LEVELS = (2, 5, 10, 15, 20, 30, 50)  # [%]
_TURN_LEVELS = (2, 5, 10, 20, 30, 40, 60)  # [deg]


@dataclass(frozen=True, eq=False)
class PlaceMap:
    """Cells over the place of a finger (n columns) and the friction of the fingers (m rows).

    Attributes:
        axis: what the place is, with its unit.
        place: (n,) ascending.
        own: the scene's own place.
        friction: (m,) ascending.
        share: (m, n) least force of the leaving finger while the tool rests, over its starting
            force; 0 where it can leave. NaN where there is none, which is hatched.
        needed_deg: (m, n) smallest turn after which the others hold the tool; NaN if none.
        failed: (m, n) whether the planner found no motion.
        detour: (m, n) whether it turned much more than needed.
    """

    axis: str
    place: Array
    own: float
    friction: Array
    share: Array
    needed_deg: Array
    failed: Mask
    detour: Mask


@dataclass(frozen=True, eq=False)
class FrictionLine:
    """Turn over friction (m,) at one place named ``label``; ``planned_deg`` if it is known."""

    label: str
    friction: Array
    needed_deg: Array
    planned_deg: Array | None = None


@dataclass(frozen=True, eq=False)
class SectionFinger:
    """A finger in the handle's section: where it touches [mm], its inward normal (2,)."""

    finger: str
    place: Array
    inward: Array
    leaves: bool


@dataclass(frozen=True, eq=False)
class HandleSection:
    """The handle's section, up is up.

    Attributes:
        outline: (n, 2) [mm].
        swept: (k, 2) places of the finger that is moved [mm].
        ends: names of the first and the last of them.
        fingers: all contacts.
    """

    outline: Array
    swept: Array
    ends: tuple[str, ...]
    fingers: tuple[SectionFinger, ...]


@styled
def pivoting_maps(
    maps: Sequence[PlaceMap],
    lines: Sequence[FrictionLine],
    section: HandleSection,
    *,
    leaving: str,
    moved: str,
) -> Any:
    """Left: how far a finger unloads while the tool rests. Middle: the pivoting it takes instead.

    Args:
        maps: two, one per row.
        lines: drawn in the last column, the one of the scene's own place last.
        section: of the handle, drawn below them.
        leaving: the finger that is removed.
        moved: the finger whose place is varied.
    """
    figure = new_figure(PAGE_WIDTH, 4.7)
    axes = figure.subplots(3, 3, width_ratios=(1.0, 1.0, 0.95), height_ratios=(1.0, 1.0, 0.05))
    share_top = 5.0 * np.ceil(20.0 * _largest([each.share for each in maps]))
    turn_top = 10.0 * np.ceil(_largest([each.needed_deg for each in maps]) / 10.0)
    for row, each in enumerate(maps):
        left, right = axes[row, :2]
        share = 100.0 * each.share
        first = _draw_map(left, each, share, share_top, "YlOrBr", _SHARE_LEVELS, " %")
        _name_free(left, each, share, f"{leaving}\nmay leave")
        second = _draw_map(right, each, each.needed_deg, turn_top, "GnBu", _TURN_LEVELS, "°")
        _name_free(right, each, each.needed_deg, "no pivoting\nneeded")
        marks = [_mark(right, each, each.failed, "x"), _mark(right, each, each.detour, "o")]
        for panel in (left, right):
            panel.set_xlabel(f"{moved} {each.axis}")
        left.set_ylabel("finger friction μ [-]")
    axes[0, 0].set_title(f"tool at rest: {leaving} must keep\n[% of its starting force]")
    axes[0, 1].set_title(f"pivoting needed to\nremove {leaving} [deg]")
    for mesh, column in ((first, 0), (second, 1)):
        bar = figure.colorbar(mesh, cax=axes[2, column], orientation="horizontal")
        bar.locator = MaxNLocator(6, integer=True)
        bar.update_ticks()
    axes[2, 2].axis("off")
    _draw_lines(axes[0, 2], lines, FINGER_COLOURS.get(moved, LIMIT_COLOUR))
    axes[0, 2].set_title(f"pivoting for {moved}\nat {lines[-1].label} and beside it")
    _draw_section(axes[1, 2], section, moved)
    own = axes[0, 0].plot([], [], "v", color=LIMIT_COLOUR, ms=4)[0]
    edge = axes[0, 0].plot([], [], color=LIMIT_COLOUR, lw=1.2, ls=(0, (3, 1.5)))[0]
    entries = [(own, "scene's own place"), (edge, "no pivoting beyond")]
    if _any(maps, "failed"):
        entries.append((marks[0], "no motion found"))
    if _any(maps, "detour"):
        entries.append((marks[1], "planned turn far above need"))
    handles, texts = zip(*entries, strict=True)
    place = {"loc": "outside lower left", "ncols": len(entries), "frameon": False}
    figure.legend(handles, texts, handletextpad=0.4, columnspacing=1.5, **place)
    return figure


def _largest(grids: Sequence[Array]) -> float:
    known = [float(np.nanmax(grid)) for grid in grids if np.isfinite(grid).any()]
    return max(known, default=0.0) or 1e-3


def _any(maps: Sequence[PlaceMap], which: str) -> bool:
    return any(bool(getattr(each, which).any()) for each in maps)


def _draw_map(
    axes: Any,
    data: PlaceMap,
    values: Array,
    top: float,
    colours: str,
    levels: Sequence[float],
    unit: str,
) -> Any:
    """Cells with their own colour, contours between their centres; returns the mesh."""
    grid = (data.place, data.friction)
    known = np.ma.masked_invalid(values)
    mesh = axes.pcolormesh(*grid, known, cmap=colours, vmin=0.0, vmax=top, shading="nearest")
    mesh.set_rasterized(True)
    unknown = np.ma.getmaskarray(known)
    if unknown.any():
        hatched = np.ma.masked_where(~unknown, np.ones(values.shape))
        axes.pcolor(*grid, hatched, hatch="////", alpha=0.0, shading="nearest")
    inside = [level for level in levels if known.min() < level < known.max()]
    if inside:
        lines = axes.contour(*grid, known, levels=inside, colors=LIMIT_COLOUR, linewidths=0.7)
        labels = axes.clabel(lines, fmt=lambda v: f"{v:g}{unit}", fontsize=7, inline_spacing=2)
        for label in labels:
            label.set_path_effects([_HALO])
    if known.min() == 0.0 < known.max():
        style = {"colors": LIMIT_COLOUR, "linewidths": 1.2, "linestyles": [(0, (4, 2))]}
        axes.contour(*grid, known, levels=[1e-3 * top], **style)
    axes.plot(data.own, 1.0, "v", color=LIMIT_COLOUR, ms=4, clip_on=False, transform=_across(axes))
    axes.xaxis.set_major_locator(MaxNLocator(5))
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)
    return mesh


def _across(axes: Any) -> Any:
    """x in data, y in shares of the panel."""
    return axes.get_xaxis_transform()


def _name_free(axes: Any, data: PlaceMap, values: Array, text: str) -> None:
    """Write ``text`` into the middle of the cells with value 0, if there is room."""
    free = values == 0.0
    if free.sum() <= 0.08 * free.size:
        return
    row, column = _middle(free)
    style = {"ha": "center", "va": "center", "fontsize": 7, "color": LIMIT_COLOUR}
    axes.text(data.place[column], data.friction[row], text, path_effects=[_HALO], **style)


def _middle(inside: Mask) -> tuple[int, int]:
    """The cell of a region that is farthest from the cells outside it."""
    depth, layer = np.zeros(inside.shape), inside
    while layer.any():
        depth += layer
        padded = np.pad(layer, 1)
        around = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
        layer = layer & np.logical_and.reduce(around)
    deepest = np.argwhere(depth == depth.max())
    nearest = np.linalg.norm(deepest - deepest.mean(axis=0), axis=1).argmin()
    return int(deepest[nearest, 0]), int(deepest[nearest, 1])


def _mark(axes: Any, data: PlaceMap, which: Mask, marker: str) -> Any:
    rows, columns = np.nonzero(which)
    style = {"color": LIMIT_COLOUR, "ms": 3.5, "mew": 0.8, "mfc": "none", "clip_on": False}
    places = data.place[columns], data.friction[rows]
    line = axes.plot(*places, marker, zorder=5, **style)[0]
    line.set_in_layout(False)  # without cells it would claim the figure's corner
    return line


def _draw_lines(axes: Any, lines: Sequence[FrictionLine], colour: str) -> None:
    for line in lines:
        own = line is lines[-1]
        tint = colour if own else _QUIET
        axes.plot(line.friction, line.needed_deg, color=tint, lw=1.4 if own else 0.9)
        if line.planned_deg is not None:
            every = max(1, len(line.friction) // 14)
            dots = {"ms": 3.0, "mfc": "white", "mew": 0.8, "zorder": 3}
            axes.plot(line.friction, line.planned_deg, "o", color=tint, markevery=every, **dots)
            _explain(axes, tint)
        places = line.friction[0], line.needed_deg[0]
        style = {"ha": "left", "va": "bottom", "fontsize": 7, "color": tint}
        axes.annotate(line.label, places, xytext=(3, 2), textcoords="offset points", **style)
    axes.set(xlabel="finger friction μ [-]", ylabel="pivoting [deg]")
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))


def _explain(axes: Any, colour: str) -> None:
    """Legend of line and dots, without covering either."""
    axes.plot([], [], color=colour, lw=1.4, label="needed")
    axes.plot([], [], "o", color=colour, ms=3.0, mfc="white", mew=0.8, label="planned")
    axes.legend(frameon=False, loc="upper right", handlelength=1.2, borderaxespad=0.0, fontsize=7)


def _draw_section(axes: Any, section: HandleSection, moved: str) -> None:
    outline = section.outline
    hub = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
    size = float((outline.max(axis=0) - outline.min(axis=0)).max()) / 2.0
    axes.fill(*outline.T, facecolor="#ECECEC", edgecolor=LIMIT_COLOUR, lw=0.8)
    colour = FINGER_COLOURS.get(moved, LIMIT_COLOUR)
    axes.plot(*section.swept.T, color=colour, lw=4.0, alpha=0.45, solid_capstyle="butt")
    label = {"fontsize": 7, "ha": "center", "va": "center"}
    for end, place in zip(section.ends, section.swept[[0, -1]], strict=True):
        out = (place - hub) / np.linalg.norm(place - hub)
        axes.annotate(end, place + 0.32 * size * out, color=_QUIET, **label)
    for each in section.fingers:
        tint = FINGER_COLOURS.get(each.finger, LIMIT_COLOUR)
        tail = each.place - 0.7 * size * each.inward
        arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": tint, "lw": 1.4}
        arrow |= {"shrinkA": 0, "shrinkB": 0, "linestyle": (0, (3, 2)) if each.leaves else "-"}
        axes.annotate("", each.place, tail, arrowprops=arrow)
        text = f"{each.finger}\n(leaves)" if each.leaves else each.finger
        side = "center" if abs(each.inward[0]) < 0.5 else "left" if each.inward[0] < 0 else "right"
        name = {**label, "ha": side, "fontsize": 8}
        axes.annotate(text, tail - 0.16 * size * each.inward, color=tint, **name)
    height = outline[:, 1].max() + 0.35 * size
    axes.plot([hub[0] - 5.0, hub[0] + 5.0], [height, height], color=LIMIT_COLOUR, lw=1.5)
    axes.annotate("10 mm", (hub[0], height + 0.2 * size), **label)
    axes.set_title("handle after the lift, from behind")
    axes.set_aspect("equal")
    axes.set_xlim(hub[0] - 2.8 * size, hub[0] + 2.8 * size)
    axes.set_ylim(outline[:, 1].min() - 1.3 * size, height + 0.4 * size)
    axes.axis("off")
