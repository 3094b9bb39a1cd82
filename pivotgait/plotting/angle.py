"""Angles between contact forces and their normals over a phase (as Xue et al., Fig. 4b)."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.contacts.cone import split_force
from pivotgait.margins.gait import LEAST_FORCE_N
from pivotgait.plans.plan import PIVOT, GaitPlan, Phase
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.style import (
    COLUMN_WIDTH,
    LIMIT_COLOUR,
    contact_colours,
    contact_strokes,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import find_phase, phase_title


@styled
def angle_to_normal(plan: GaitPlan, phase: str) -> Any:
    """Angle of each contact force to its normal, with the friction angles as limits.

    Args:
        plan: a gait.
        phase: the phase's name in ``plan``.

    Returns:
        A matplotlib ``Figure`` of column width.

    Raises:
        UnknownNameError: if ``plan`` has no such phase.
    """
    shown = find_phase(plan, phase)
    colours, strokes = contact_colours(plan), contact_strokes(plan)
    figure = new_figure(COLUMN_WIDTH, 2.4)
    axes = figure.subplots()
    time = shown.time - shown.time[0]
    limits: dict[float, list[str]] = {}
    labels = []
    for name, track in shown.contacts.items():
        normal, tangential = split_force(track.force, track.world_normal(shown.tool))
        angle = np.where(normal > LEAST_FORCE_N, np.degrees(np.arctan2(tangential, normal)), np.nan)
        axes.plot(time, angle, **strokes[name])
        limits.setdefault(float(np.degrees(np.arctan(track.friction))), []).append(name)
        defined = angle[np.isfinite(angle)]
        labels += [EndLabel(name, float(defined[-1]), colours[name])] if defined.size else []
    for limit, names in limits.items():
        colour = colours[names[0]] if len(names) == 1 else LIMIT_COLOUR
        axes.axhline(limit, color=colour, lw=0.8, ls=(0, (4, 3)))
        labels.append(EndLabel(f"{_who(names, shown)} ≤ {limit:.1f}°", limit, colour))
    axes.set_xlim(0.0, time[-1])
    axes.set_ylim(0.0, 1.12 * max(limits))
    axes.set_xlabel("time in the phase [s]")
    axes.set_ylabel("angle to the normal [deg]")
    axes.set_title(phase_title(shown), fontweight="bold")
    label_right(axes, labels)
    return figure


def _who(names: list[str], phase: Phase) -> str:
    """The contacts of one friction coefficient in as few words as can be."""
    if len(names) == len(phase.contacts):
        return "all"
    fingers = [name for name in phase.contacts if name != PIVOT]
    return "fingers" if names == fingers and len(names) > 1 else ", ".join(names)
