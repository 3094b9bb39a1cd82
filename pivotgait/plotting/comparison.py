"""One plan in several engines: forces, orientation and slips of each beside the plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.plans.plan import PIVOT, GaitPlan
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.run_axes import since_start
from pivotgait.plotting.style import (
    PAGE_WIDTH,
    contact_colours,
    contact_names,
    mixed,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import shade_phases
from pivotgait.validation.metrics import normal_forces
from pivotgait.validation.record_reading import RecordedMotion

ENGINE_NAMES = MappingProxyType({"pybullet": "PyBullet", "mujoco": "MuJoCo"})
"""Engines as their makers write them."""
_STROKES: tuple[dict[str, Any], ...] = (
    {"ls": "-", "lw": 0.9},
    {"ls": (0, (3, 1.5)), "lw": 1.1},
    {"ls": (0, (1, 1)), "lw": 1.1},
)
_PALE = 0.6
_INK, _GREY = "#333333", "#999999"


@styled
def comparison(plan: GaitPlan, motions: Mapping[str, RecordedMotion]) -> Any:
    """Normal force of each finger, error of the orientation and slips, in each engine.

    The plan is a broad pale line; the first engine is drawn through, the second dashed.

    Args:
        plan: that all carried out.
        motions: engine's name -> the record of its run, up to three.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        InputError: none or more than three engines.
    """
    if not 1 <= len(motions) <= len(_STROKES):
        what = f"{len(motions)} engines"
        raise InputError(what, where="comparison", mend=f"give 1 to {len(_STROKES)}")
    touching = {name for phase in plan.phases for name in phase.contacts}
    names = [each for each in contact_names(plan) if each in touching and each != PIVOT]
    figure = new_figure(PAGE_WIDTH, 0.7 + 0.95 * (len(names) + 3))
    panels = figure.subplots(len(names) + 3, 1, sharex=True)
    end = max(float(motion.series.time[-1]) for motion in motions.values())
    for number, axes in enumerate(panels):
        shade_phases(axes, plan, named=number == 0, end=end)
    colours = contact_colours(plan)
    for axes, name in zip(panels, names, strict=False):
        _forces(axes, name, motions, colours[name])
    turn, tip, fingers = panels[len(names) :]
    _curves(turn, motions, lambda motion: np.degrees(motion.orientation_error))
    turn.set_ylabel("orientation\nerror [deg]")
    _curves(tip, motions, lambda motion: 1e3 * motion.tip_slip)
    tip.set_ylabel("tip slip\n[mm]")
    _curves(fingers, motions, _largest_slip)
    fingers.set_ylabel("fingertip slip,\nlargest [mm]")
    figure.align_ylabels(panels)
    fingers.set_xlabel("time [s]")
    _legend(figure, motions)
    return figure


def _forces(axes: Any, name: str, motions: Mapping[str, RecordedMotion], colour: str) -> None:
    """Planned and measured normal force of one finger."""
    longest = max(motions.values(), key=lambda motion: float(motion.series.time[-1]))
    place, top = longest.series.fingers.index(name), 0.0
    time, planned = since_start(longest, longest.planned.normal_force[:, place])
    axes.plot(time, planned, color=mixed(colour, _PALE), lw=3.0, label="plan")
    for motion, stroke in zip(motions.values(), _STROKES, strict=False):
        along = normal_forces(motion.series, motion.planned)[:, place]
        time, force = since_start(motion, along)
        axes.plot(time, force, color=colour, **stroke)
        top = max(top, float(force.max()), float(planned.max()))
    axes.set_ylim(0.0, 1.15 * top or 1.0)
    axes.set_ylabel("normal\nforce [N]")
    label_right(axes, [EndLabel(name, 0.6 * top, colour)])


def _curves(
    axes: Any,
    motions: Mapping[str, RecordedMotion],
    values: Callable[[RecordedMotion], Array],
) -> None:
    top, labels = 0.0, []
    for (name, motion), stroke in zip(motions.items(), _STROKES, strict=False):
        time, curve = since_start(motion, values(motion))
        axes.plot(time, curve, color=_INK, **stroke)
        top = max(top, float(curve.max(initial=0.0)))
        labels.append(EndLabel(ENGINE_NAMES.get(name, name), float(curve[-1]), _INK))
    axes.set_ylim(0.0, 1.15 * top or 1.0)
    label_right(axes, labels)


def _largest_slip(motion: RecordedMotion) -> Array:
    slips = list(motion.fingertip_slips.values())
    return np.asarray(1e3 * np.max(slips, axis=0))


def _legend(figure: Any, motions: Mapping[str, RecordedMotion]) -> None:
    """What the strokes mean, below everything."""
    handles = [Line2D([], [], color=mixed(_GREY, 0.3), lw=3.0, label="plan")]
    for name, stroke in zip(motions, _STROKES, strict=False):
        handles.append(Line2D([], [], color=_INK, label=ENGINE_NAMES.get(name, name), **stroke))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
