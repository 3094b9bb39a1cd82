"""How trials end with and without recovery, under one condition after another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pivotgait.plotting.curves import COLOURS
from pivotgait.plotting.margin_prediction import FAILED_COLOUR, PASSED_COLOUR
from pivotgait.plotting.style import PAGE_WIDTH, new_figure, styled

FIRST = {"passed": PASSED_COLOUR, "put-back": "#56B4E9"}
"""Classes that are stacked first, with their colours."""
_ROOM, _HATCHES = 0.8, ("", "//", "\\\\", "xx", "..", "--", "++")


@styled
def recovery_study(classes: Mapping[str, Mapping[str, Mapping[str, int]]]) -> Any:
    """Stacked bars of the trials' outcomes.

    Args:
        classes: condition -> way (such as ``with`` and ``without``) -> outcome -> trials.
    """
    figure = new_figure(PAGE_WIDTH, 2.6)
    axes = figure.subplots()
    looks = _looks(classes)
    told: set[str] = set()
    for row, ways in enumerate(classes.values()):
        for k, (way, counts) in enumerate(ways.items()):
            width = _ROOM / len(ways)
            at, below = row + (k - 0.5 * (len(ways) - 1)) * width, 0
            for name, look in looks.items():
                count = counts.get(name, 0)
                if count:
                    label = None if name in told else name
                    told.add(name)
                    axes.bar(at, count, 0.9 * width, bottom=below, label=label, **look)
                    below += count
            axes.text(at, below, f" {way}", ha="center", va="bottom", fontsize=6.0, rotation=90)
    axes.set_xticks(range(len(classes)), list(classes))
    axes.set_ylabel("trials")
    axes.margins(y=0.25)
    axes.yaxis.get_major_locator().set_params(integer=True)
    figure.legend(loc="outside lower center", ncols=5, frameon=False, fontsize=7.0)
    return figure


def _looks(classes: Mapping[str, Mapping[str, Mapping[str, int]]]) -> dict[str, dict[str, Any]]:
    """Colour and hatch of each outcome, the successes first."""
    found = {name for ways in classes.values() for counts in ways.values() for name in counts}
    looks: dict[str, dict[str, Any]] = {name: {"color": colour} for name, colour in FIRST.items()}
    for k, name in enumerate(sorted(found - FIRST.keys())):
        colour = FAILED_COLOUR if k == 0 else COLOURS[(k + 2) % len(COLOURS)]
        looks[name] = {
            "facecolor": colour,
            "edgecolor": "white",
            "hatch": _HATCHES[k % len(_HATCHES)],
        }
    return looks
