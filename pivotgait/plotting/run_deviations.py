"""How far a run strays from its plan: slips of tip and fingertips, orientation of the tool."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.run_axes import draw_limit, shade_run, since_start
from pivotgait.plotting.style import (
    PAGE_WIDTH,
    PIVOT_COLOUR,
    contact_strokes,
    new_figure,
    styled,
)
from pivotgait.validation.record_reading import RecordedMotion
from pivotgait.validation.verdict import Rule

_INK = "#333333"


@styled
def run_deviations(plan: GaitPlan, motion: RecordedMotion, rule: Rule | None = None) -> Any:
    """Slip of the tip, slip of each fingertip and error of the orientation, with their limits.

    Args:
        plan: that was carried out.
        motion: the record of its run.
        rule: that holds the limits; the default one if not given.

    Returns:
        A matplotlib ``Figure`` of page width.
    """
    rule = rule or Rule()
    figure = new_figure(PAGE_WIDTH, 4.2)
    tip, fingers, turn = panels = figure.subplots(3, 1, sharex=True)
    for number, axes in enumerate(panels):
        shade_run(axes, plan, motion, named=number == 0)
    strokes = contact_strokes(plan)
    on_table = {"color": PIVOT_COLOUR, "lw": 1.2}
    _draw(tip, motion, {"tip": 1e3 * motion.tip_slip}, {"tip": on_table}, 1e3 * rule.tip_slip_m)
    _draw(fingers, motion, _counted_slips(motion), strokes, 1e3 * rule.fingertip_slip_m)
    error = {"tool": np.degrees(motion.orientation_error)}
    _draw(turn, motion, error, {"tool": {"color": _INK, "lw": 1.2}}, rule.orientation_deg, "°")
    tip.set_ylabel("tip slip\n[mm]")
    fingers.set_ylabel("fingertip\nslip [mm]")
    turn.set_ylabel("orientation\nerror [deg]")
    figure.align_ylabels(panels)
    turn.set_xlabel("time [s]")
    return figure


def _counted_slips(motion: RecordedMotion) -> dict[str, Array]:
    """Slip of each fingertip [mm], NaN while it neither holds nor bears on its way."""
    found = {}
    for name, slip in motion.fingertip_slips.items():
        place = motion.series.fingers.index(name)
        holds = motion.planned.holds[:, place] > 0.0
        found[name] = np.where(holds | (slip > 0.0), 1e3 * slip, np.nan)
    return found


def _draw(
    axes: Any,
    motion: RecordedMotion,
    curves: Mapping[str, Array],
    strokes: Mapping[str, Mapping[str, Any]],
    limit: float,
    unit: str = " mm",
) -> None:
    """Curves from zero up, each named at its end, below their common limit."""
    labels, largest = [], limit
    for name, curve in curves.items():
        time, values = since_start(motion, curve)
        axes.plot(time, values, label=name, **strokes[name])
        known = values[np.isfinite(values)]
        if known.size:
            labels.append(EndLabel(name, float(known[-1]), strokes[name]["color"]))
            largest = max(largest, float(known.max()))
    axes.set_ylim(0.0, 1.12 * largest)
    labels.append(draw_limit(axes, limit, f"limit {limit:g}{unit}"))
    label_right(axes, labels)
