"""What engines make of a plan: a removal's forces (as Xue et al., Fig. 4), and what holds where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.patches import Polygon, Rectangle
from scipy.spatial.transform import Rotation

from pivotgait.contacts.cone import split_force
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.plans.plan import PIVOT, GaitPlan
from pivotgait.plotting.comparison import ENGINE_NAMES
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.run_forces import LEAST_LOAD_N
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    contact_strokes,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import find_phase, spans
from pivotgait.validation.record_reading import RecordedMotion

HOLDS_COLOUR, FAILS_COLOUR = "#009E73", "#D55E00"
_UP = np.array([0.0, 0.0, 1.0])


class _Forces(NamedTuple):
    """Tangential and normal force [N] of each contact over (N,) time in a phase [s]."""

    time: Array
    split: Mapping[str, tuple[Array, Array]]


@styled
def removal_in_engines(plan: GaitPlan, phase: str, motions: Mapping[str, RecordedMotion]) -> Any:
    """The force that is removed in its friction cone, and every force's angle to its normal.

    One column for the plan and one for each engine; rows as (a) and (b) of the paper's figure.

    Args:
        plan: that was carried out.
        phase: name of one of its removals or additions.
        motions: engine's name -> the record of its run, which came through the phase.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        UnknownNameError: no such phase.
        InputError: a phase without a changing finger.
    """
    shown = find_phase(plan, phase)
    track = shown.contacts.get(shown.finger)
    if track is None:
        mend = "name a removal or an addition"
        raise InputError("no contact comes or goes", where=phase, mend=mend)
    columns = {"plan": _planned(plan, phase)}
    columns |= {
        ENGINE_NAMES.get(name, name): _measured(plan, phase, each) for name, each in motions.items()
    }
    figure = new_figure(PAGE_WIDTH, 4.4)
    panels = figure.subplots(2, len(columns), sharex="row", sharey="row", squeeze=False)
    top = 1.15 * max(float(each.split[shown.finger][0].max()) for each in columns.values())
    colours = contact_colours(plan)
    for (above, below), (name, forces) in zip(panels.T, columns.items(), strict=True):
        above.set_title(name, fontweight="bold")
        _cone(above, forces.split[shown.finger], track.friction, top, colours[shown.finger])
        _angles(below, plan, phase, forces)
    panels[0, 0].set_ylabel(f"normal force of\nthe {shown.finger} [N]")
    panels[1, 0].set_ylabel("angle to the\nnormal [deg]")
    _name(panels[1, -1], plan, columns)
    return figure


def _planned(plan: GaitPlan, name: str) -> _Forces:
    phase = find_phase(plan, name)
    split = {
        each: split_force(track.force, track.world_normal(phase.tool))
        for each, track in phase.contacts.items()
    }
    return _Forces(phase.time - phase.time[0], split)


def _measured(plan: GaitPlan, name: str, motion: RecordedMotion) -> _Forces:
    """Normals are the planned ones, turned with the real tool."""
    series, span = motion.series, next(s for s in spans(plan) if s.phase.name == name)
    rows = (series.time >= span.start) & (series.time <= span.end)
    turn = Rotation.from_quat(series.tool_orientation[rows]).as_matrix()
    split = {}
    for each, track in span.phase.contacts.items():
        if each == PIVOT:
            force = series.pivot_force[rows]
            split[each] = split_force(force, np.broadcast_to(_UP, force.shape))
        else:
            force = series.force[rows, series.fingers.index(each)]
            split[each] = split_force(force, turn @ track.normal)
    return _Forces(series.time[rows] - span.start, split)


def _cone(axes: Any, split: tuple[Array, Array], friction: float, top: float, colour: str) -> None:
    normal, tangential = split
    wedge = [[0.0, 0.0], [friction * top, top], [0.0, top]]
    axes.add_patch(Polygon(wedge, facecolor=colour, alpha=0.13, lw=0))
    axes.plot([0.0, friction * top], [0.0, top], color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    axes.plot(tangential, normal, color=colour)
    axes.plot(tangential[0], normal[0], "o", color="white", mec=colour, ms=4, clip_on=False)
    axes.plot(tangential[-1], normal[-1], "o", color=colour, ms=4, clip_on=False)
    axes.set_xlim(0.0, 1.05 * friction * top)
    axes.set_ylim(0.0, top)
    axes.set_xlabel("tangential force [N]")


def _angles(axes: Any, plan: GaitPlan, name: str, forces: _Forces) -> None:
    phase, strokes = find_phase(plan, name), contact_strokes(plan)
    for each, (normal, tangential) in forces.split.items():
        axes.plot(forces.time, _angle(normal, tangential), **strokes[each])
    limits = {float(np.degrees(np.arctan(each.friction))) for each in phase.contacts.values()}
    for limit in limits:
        axes.axhline(limit, color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    axes.set_xlim(0.0, phase.duration_s)
    axes.set_ylim(0.0, 1.12 * max(limits))
    axes.set_xlabel("time in the phase [s]")


def _name(axes: Any, plan: GaitPlan, columns: Mapping[str, _Forces]) -> None:
    colours, labels = contact_colours(plan), []
    for each, (normal, tangential) in list(columns.values())[-1].split.items():
        known = _angle(normal, tangential)
        known = known[np.isfinite(known)]
        if known.size:
            labels.append(EndLabel(each, float(known[-1]), colours[each]))
    label_right(axes, labels)


def _angle(normal: Array, tangential: Array) -> Array:
    """(N,) [deg]; NaN where the contact bears next to nothing."""
    return np.where(normal > LEAST_LOAD_N, np.degrees(np.arctan2(tangential, normal)), np.nan)


@styled
def conclusions_grid(
    settings: Sequence[str], conclusions: Sequence[str], holds: Mapping[str, Array]
) -> Any:
    """Which conclusions hold under which settings in which engine.

    Args:
        settings: names, one for each row.
        conclusions: names, one for each column.
        holds: engine's name -> (settings, conclusions) 1 where it holds, 0 where not, NaN where
            nobody looked.

    Returns:
        A matplotlib ``Figure`` of page width: in each cell a field for each engine, green with a
        tick where it holds, orange with a cross where not.
    """
    figure = new_figure(PAGE_WIDTH, 1.3 + 0.22 * len(settings))
    axes = figure.subplots()
    width = 0.9 / len(holds)
    for place, values in enumerate(holds.values()):
        for row, column in np.argwhere(np.isfinite(values)):
            left = column - 0.45 + place * width
            good = values[row, column] > 0.5
            colour = HOLDS_COLOUR if good else FAILS_COLOUR
            axes.add_patch(Rectangle((left, row - 0.4), width, 0.8, color=colour, alpha=0.35, lw=0))
            middle = (left + 0.5 * width, row)
            axes.annotate("✓" if good else "✗", middle, ha="center", va="center", fontsize=7)
    axes.set_xlim(-0.5, len(conclusions) - 0.5)
    axes.set_ylim(len(settings) - 0.5, -0.5)
    axes.set_yticks(range(len(settings)), settings)
    axes.set_xticks(range(len(conclusions)), conclusions)
    axes.tick_params(length=0, labeltop=True, labelbottom=False)
    for side in axes.spines.values():
        side.set_visible(False)
    engines = [ENGINE_NAMES.get(each, each) for each in holds]
    axes.set_xlabel(f"in each cell from left to right: {', '.join(engines)}")
    return figure
