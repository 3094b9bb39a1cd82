"""The figure of a verdict's margins: a bar for each phase and kind, the least marked."""

from __future__ import annotations

import matplotlib as mpl
import pytest
from matplotlib.colors import to_hex

from pivotgait import plotting
from pivotgait.feasibility.gait_margins import GaitMargins
from pivotgait.plotting.robust_margins import LEAST_COLOUR

KEYS = ("friction_drop", "mass_increase", "sensing_share", "lift_off_N", "wrench_ball_N")


def margins(*rows: tuple[float | None, ...]) -> GaitMargins:
    by_phase = {f"{k:02d}_phase": dict(zip(KEYS, row, strict=True)) for k, row in enumerate(rows)}
    return GaitMargins(None, None, {}, by_phase, None, None, None)


GOOD = margins((0.66, 1.9, 0.24, 0.3, 0.29), (0.25, 1.7, 0.21, 0.6, 0.017))
LOST = margins((0.66, 1.9, 0.24, 0.3, 0.29), (-0.33, None, None, None, 0.0))


@pytest.mark.parametrize("given", [GOOD, LOST])
def test_every_axis_names_its_unit_and_letters_are_readable(given):
    figure = plotting.robust_margins(given)
    assert figure.get_figwidth() == plotting.PAGE_WIDTH
    assert all(axes.get_xlabel().endswith("]") for axes in figure.axes)
    figure.draw_without_rendering()
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 7.0
    page = figure.bbox.padded(2.0)
    for axes in figure.axes:
        for text in axes.texts:
            box = text.get_window_extent()
            assert page.contains(box.x0, box.y0)
            assert page.contains(box.x1, box.y1)


def test_bars_are_as_long_as_the_margins():
    for axes, key in zip(plotting.robust_margins(GOOD).axes, KEYS, strict=True):
        wanted = [values[key] for values in GOOD.by_phase.values()]
        scale = 1.0 if key.endswith("_N") else 100.0
        assert [bar.get_width() / scale for bar in axes.patches] == pytest.approx(wanted)
        least = min(range(2), key=lambda k: wanted[k])
        colours = [to_hex(bar.get_facecolor(), keep_alpha=False) for bar in axes.patches]
        assert [c == LEAST_COLOUR.lower() for c in colours] == [k == least for k in range(2)]


def test_what_is_missing_has_no_bar():
    counts = [len(axes.patches) for axes in plotting.robust_margins(LOST).axes]
    assert counts == [2, 1, 1, 1, 2]
    assert plotting.robust_margins(LOST).axes[0].get_xlim()[0] < -33.0
