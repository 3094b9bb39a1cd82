"""What perturbations leave of a margin, and how well the margin tells failures from successes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plotting.curves import COLOURS
from pivotgait.plotting.style import LIMIT_COLOUR, PAGE_WIDTH, PIVOT_COLOUR, new_figure, styled

PASSED_COLOUR, FAILED_COLOUR = "#0072B2", "#D55E00"
NAMES = {
    "mass_scale": "mass",
    "finger_friction_scale": "friction of fingers",
    "table_friction_scale": "friction of table",
    "offset_x": "tool off along x",
    "offset_y": "tool off along y",
    "offset_yaw": "tool off in yaw",
    "handle_growth": "width of handle",
    "margin": "forces free",
    "held_margin": "forces held",
    "sensed_margin_N": "forces as sensed",
}
_DASHES = ("-", "--", ":", "-.")
_CURVES = ((PIVOT_COLOUR, "-."), (LIMIT_COLOUR, "-"), (FAILED_COLOUR, "--"))

_OUTLIERS = 2.5
"""Per cent of the margins, the least ones, that share the first bar: they would set its scale."""


@dataclass(frozen=True, eq=False)
class MarginPrediction:
    """Margins and outcomes of n trials.

    Attributes:
        shares: (k,) of a perturbation's half width, -1 to 1.
        eaten: perturbation -> (k,) margin under it alone.
        margin: (n,) of each trial's draw, of the forces as sensed [N].
        passed: (n,) 1 or 0.
        curves: score -> false and true positive rates.
        area: score -> area under its ROC curve; NaN where all passed, or all failed.
    """

    shares: Array
    eaten: Mapping[str, Array]
    margin: Array
    passed: Array
    curves: Mapping[str, tuple[Array, Array]]
    area: Mapping[str, float]


@styled
def margin_prediction(found: MarginPrediction) -> Any:
    """Margin under each perturbation; margins of passed and failed trials; ROC curves."""
    figure = new_figure(PAGE_WIDTH, 3.0)
    sweep, split, curve = figure.subplots(1, 3)
    _draw_eaten(sweep, found)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=7.0)
    _draw_split(split, found)
    _draw_curves(curve, found)
    return figure


def _draw_eaten(axes: Any, found: MarginPrediction) -> None:
    for k, (name, margin) in enumerate(found.eaten.items()):
        look = {"color": COLOURS[k % len(COLOURS)], "ls": _DASHES[k % len(_DASHES)]}
        axes.plot(100.0 * found.shares, margin, label=NAMES[name], **look)
    axes.set_xlabel("perturbation [% of its half width]")
    axes.set_ylabel("least friction margin [-]")


def _draw_split(axes: Any, found: MarginPrediction) -> None:
    if found.margin.size:
        low, high = float(np.percentile(found.margin, _OUTLIERS)), float(found.margin.max())
        bins = np.linspace(low, max(high, low + 0.05), 13)
        shown = np.maximum(found.margin, low)
        groups = [shown[found.passed == each] for each in (1.0, 0.0)]
        names = [f"passed ({len(groups[0])})", f"failed ({len(groups[1])})"]
        colours = [PASSED_COLOUR, FAILED_COLOUR]
        axes.hist(groups, bins=bins, stacked=True, color=colours, label=names)
        axes.legend(frameon=False, fontsize=7.0)
    axes.set_xlabel("margin of the forces as sensed [N]\n(first bar: and below)")
    axes.set_ylabel("trials")


def _draw_curves(axes: Any, found: MarginPrediction) -> None:
    axes.plot([0, 1], [0, 1], color=PIVOT_COLOUR, lw=0.8, ls=":")
    for k, (name, (false, true)) in enumerate(found.curves.items()):
        area = found.area[name]
        known = f"{area:.2f}" if np.isfinite(area) else "–"
        colour, dashes = _CURVES[k % len(_CURVES)]
        axes.plot(false, true, color=colour, ls=dashes, label=f"{NAMES[name]}: {known}")
    axes.set_xlabel("passed trials flagged [-]")
    axes.set_ylabel("failed trials flagged [-]")
    axes.set_aspect("equal")
    axes.set_title("area under the curve")
    axes.legend(frameon=False, fontsize=6.5, loc="lower right")
