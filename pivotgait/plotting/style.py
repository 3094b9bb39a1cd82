"""How every figure looks: sizes, fonts, and one colour per finger."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from types import MappingProxyType
from typing import Any, ParamSpec, TypeVar

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from pivotgait.plans.plan import PIVOT, GaitPlan

COLUMN_WIDTH, PAGE_WIDTH = 3.5, 7.16
"""Widths of a paper's column and page [in]."""

PIVOT_COLOUR = "#777777"
LIMIT_COLOUR = "#222222"
FINGER_COLOURS = MappingProxyType(
    {
        "thumb": "#D55E00",
        "index": "#0072B2",
        "middle": "#009E73",
        "ring": "#CC79A7",
        "little": "#E69F00",
    }
)
"""Okabe-Ito colours, which colour-blind readers can tell apart."""
_OTHERS = ("#56B4E9", "#000000", "#B09E00")

RC = MappingProxyType(
    {
        "font.family": "DejaVu Sans",
        "font.size": 8.0,
        "axes.titlesize": 8.0,
        "axes.labelsize": 8.0,
        "xtick.labelsize": 8.0,
        "ytick.labelsize": 8.0,
        "legend.fontsize": 8.0,
        "axes.linewidth": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "lines.linewidth": 1.2,
        "figure.facecolor": "white",
        "savefig.facecolor": "white",
        "savefig.dpi": 300,
        "pdf.fonttype": 42,
        "svg.fonttype": "path",
        "svg.hashsalt": "pivotgait",
    }
)

P = ParamSpec("P")
R = TypeVar("R")


def styled(make: Callable[P, R]) -> Callable[P, R]:
    """Run ``make`` under this package's settings and leave matplotlib's own untouched."""

    @wraps(make)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> R:
        with rc_context(dict(RC)):
            return make(*args, **kwargs)

    return wrapper


def new_figure(width: float, height: float) -> Any:
    """An empty figure of ``width`` x ``height`` [in] that lays itself out."""
    return Figure(figsize=(width, height), layout="constrained")


def contact_names(plan: GaitPlan) -> tuple[str, ...]:
    """The pivot, the plan's fingers in the order of first mention, then the robot's others."""
    names: dict[str, None] = {PIVOT: None}
    for phase in plan.phases:
        names |= dict.fromkeys(phase.contacts)
        if phase.finger:
            names[phase.finger] = None
    names |= dict.fromkeys(plan.robot.fingers if plan.robot else ())
    return tuple(names)


def contact_colours(plan: GaitPlan) -> dict[str, str]:
    """Colour of each contact; the same finger has the same colour in every figure.

    Fingers of the human hand own their colour. Others take the colours that are left, in the
    order of their names, so that the choice does not hang on which of them moves first.
    """
    names = contact_names(plan)
    colours = {PIVOT: PIVOT_COLOUR}
    colours |= {name: FINGER_COLOURS[name] for name in names if name in FINGER_COLOURS}
    spare = [c for c in (*FINGER_COLOURS.values(), *_OTHERS) if c not in colours.values()]
    strangers = sorted(name for name in names if name not in colours)
    colours |= {name: spare[i % len(spare)] for i, name in enumerate(strangers)}
    return colours


def mixed(colour: str, white: float) -> str:
    """``#rrggbb`` with a share of white from 0 to 1 mixed in."""
    return to_hex((1.0 - white) * np.array(to_rgb(colour)) + white)


def contact_strokes(plan: GaitPlan) -> dict[str, dict[str, Any]]:
    """How each contact's curve is drawn: its colour, and thinner the later it is named.

    Thin curves lie on thick ones, so that two that coincide are both seen.
    """
    colours, names = contact_colours(plan), contact_names(plan)
    return {
        name: {
            "color": colours[name],
            "lw": max(2.0 - 0.4 * place, 0.8),
            "zorder": 2.0 + 0.01 * place,
        }
        for place, name in enumerate(names)
    }
