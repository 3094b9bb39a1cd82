"""Figures of control laws side by side: every run has a tile, every finger a curve."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.patches import Rectangle

from pivotgait.plotting.control_study import (
    OutcomeMap,
    PressingFingers,
    outcome_maps,
    pressing_fingers,
)
from pivotgait.plotting.style import FINGER_COLOURS, PAGE_WIDTH

WIDTHS, FRICTIONS = np.array([-1.0, 0.0, 1.0]), np.array([0.6, 1.0])
FAILURE = (("slip", "", "loss"), ("", "", "timeout"))


def outcome(title: str) -> OutcomeMap:
    force = np.arange(6.0).reshape(2, 3) * 3.0
    return OutcomeMap(title, WIDTHS, FRICTIONS, FAILURE, force)


def run(title: str, scale: float) -> PressingFingers:
    time = np.linspace(-0.4, 1.2, 50)
    force = {name: scale * np.linspace(0.0, top, 50) for name, top in (("thumb", 2), ("index", 3))}
    return PressingFingers(title, time, force, force)


@pytest.mark.parametrize("figure", [
    outcome_maps([outcome("hybrid"), outcome("position")]),
    pressing_fingers([[run("hybrid", 1.0), run("position", 2.0)], [run("a", 1.0), run("b", 9.0)]]),
])  # fmt: skip
def test_figures_are_a_page_wide_and_readable(figure):
    assert figure.get_figwidth() == PAGE_WIDTH
    figure.draw_without_rendering()
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 6.0
    assert max(sizes) <= 8.0


def test_every_run_has_a_tile_and_failures_are_hatched():
    for axes in outcome_maps([outcome("hybrid"), outcome("position")]).axes:
        tiles = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
        hatched = [patch.get_hatch() is not None for patch in tiles]
        assert hatched == [bool(failure) for row in FAILURE for failure in row]
        assert [text.get_text() for text in axes.texts][-1] == "15"


def test_every_finger_has_its_colour_and_rows_share_a_scale():
    figure = pressing_fingers([[run("hybrid", 1.0), run("position", 2.0)]])
    for axes in figure.axes:
        colours = [line.get_color() for line in axes.lines]
        assert colours[0] == FINGER_COLOURS["thumb"]
        assert colours[2] == FINGER_COLOURS["index"]
        assert axes.get_ylim() == figure.axes[0].get_ylim()
        assert axes.get_ylim()[1] >= 6.0
