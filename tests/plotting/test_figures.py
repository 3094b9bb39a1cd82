"""Every figure: units on its axes, one colour per finger, no trace left in matplotlib."""

import subprocess
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex
from scipy.spatial.transform import Rotation

from pivotgait import plotting
from pivotgait.exceptions import UnknownNameError
from pivotgait.plotting.style import PIVOT_COLOUR

REMOVAL = "03_removal"
CHARTS = {
    "angle_to_normal": lambda plan: plotting.angle_to_normal(plan, REMOVAL),
    "force_in_cone": lambda plan: plotting.force_in_cone(plan, REMOVAL, "index"),
    "force_in_cone_pivot": lambda plan: plotting.force_in_cone(plan, REMOVAL, "pivot"),
    "margins": plotting.margins,
    "normal_forces": plotting.normal_forces,
    "orientation": plotting.orientation,
    "overview": plotting.overview,
}
DRAWINGS = {
    "gait_strip": plotting.gait_strip,
    "tool_snapshots": lambda plan: plotting.tool_snapshots(plan, REMOVAL),
}


def line_colours(axes):
    return {to_hex(line.get_color()) for line in axes.get_lines()}


@pytest.mark.parametrize("name", CHARTS)
def test_every_axis_names_its_unit(name, plan):
    for axes in CHARTS[name](plan).axes:
        assert axes.get_ylabel().rstrip().endswith("]"), axes.get_ylabel()
    assert CHARTS[name](plan).axes[-1].get_xlabel().endswith("]")


@pytest.mark.parametrize("name", CHARTS | DRAWINGS)
def test_width_is_a_papers_and_letters_are_readable(name, plan):
    figure = (CHARTS | DRAWINGS)[name](plan)
    assert figure.get_figwidth() in (plotting.COLUMN_WIDTH, plotting.PAGE_WIDTH)
    figure.draw_without_rendering()
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 7.0


@pytest.mark.parametrize("name", CHARTS | DRAWINGS)
def test_texts_stay_on_the_figure(name, plan):
    figure = (CHARTS | DRAWINGS)[name](plan)
    figure.draw_without_rendering()
    page = figure.bbox.padded(2.0)
    for axes in figure.axes:
        for text in axes.texts:
            box = text.get_window_extent()
            assert page.x0 <= box.x0, text.get_text()
            assert box.x1 <= page.x1, text.get_text()


def test_phases_are_shaded_and_named(plan):
    axes = plotting.margins(plan).axes[0]
    words = {text.get_text().replace("\n", " ") for text in axes.texts}
    assert {"lift", "relocation middle", "addition middle", "removal index"} <= words
    bands = [patch for patch in axes.patches if patch.get_width() > 0]
    assert [band.get_width() for band in bands] == pytest.approx([0.8, 0.5, 0.4, 1.0])


def test_a_finger_has_one_colour_in_every_figure(plan):
    colours = plotting.contact_colours(plan)
    assert len(set(colours.values())) == 4
    assert colours["pivot"] == PIVOT_COLOUR
    wanted = {to_hex(colour) for colour in colours.values()}
    assert wanted <= line_colours(plotting.margins(plan).axes[0])
    assert wanted <= line_colours(plotting.angle_to_normal(plan, REMOVAL).axes[0])
    fingers, pivot = plotting.normal_forces(plan).axes
    assert wanted - {PIVOT_COLOUR} <= line_colours(fingers)
    assert PIVOT_COLOUR in line_colours(pivot)
    assert PIVOT_COLOUR not in line_colours(fingers)


def test_curves_are_the_plans_numbers(plan):
    fingers = plotting.normal_forces(plan).axes[0]
    lines = [line for line in fingers.get_lines() if line.get_label() == "index"]
    last = plan.phases[-1]
    track = last.contacts["index"]
    force = np.einsum("ni,ni->n", track.force, track.world_normal(last.tool))
    np.testing.assert_allclose(lines[-1].get_ydata(), force)
    assert lines[-1].get_xdata()[0] == pytest.approx(1.7)
    assert lines[-1].get_xdata()[-1] == pytest.approx(2.7)


def test_turn_since_start_begins_at_zero_and_pitch_is_the_lift(plan):
    angles = plotting.orientation(plan).axes[0]
    _, pitch, _ = (line.get_ydata() for line in angles.get_lines()[:3])
    assert pitch[0] == pytest.approx(0.0, abs=1e-12)
    assert pitch[-1] == pytest.approx(20.0)


@pytest.mark.parametrize("turned", [[90.0, "x"], [-70.0, "x"], [40.0, "z"]])
def test_pitch_is_the_lift_however_the_tool_lies(turned, plan):
    """The same motion of a tool whose frame is laid out otherwise reads the same."""
    angle, axis = turned
    change = Rotation.from_euler(axis, angle, degrees=True)
    phases = tuple(
        replace(
            phase,
            tool=replace(phase.tool, orientation=(phase.tool.rotation * change).as_quat()),
        )
        for phase in plan.phases
    )
    tool = replace(plan.tool, pivot_in_tool=change.inv().as_matrix() @ plan.tool.pivot_in_tool)
    other = replace(plan, phases=phases, tool=tool)
    for ours, theirs in zip(
        plotting.orientation(plan).axes[0].get_lines(),
        plotting.orientation(other).axes[0].get_lines(),
        strict=True,
    ):
        np.testing.assert_allclose(ours.get_ydata(), theirs.get_ydata(), atol=1e-9)


def test_curves_that_coincide_are_both_seen(plan):
    lines = plotting.margins(plan).axes[0].get_lines()
    curves = {to_hex(line.get_color()): line for line in lines if line.get_marker() == "None"}
    over = [curves[to_hex(colour)] for colour in plotting.contact_colours(plan).values()]
    over.sort(key=lambda line: line.get_zorder())
    widths = [line.get_linewidth() for line in over]
    assert np.all(np.diff(widths) < 0.0)


def test_force_limits_are_drawn_at_the_friction_angle(plan):
    axes = plotting.angle_to_normal(plan, REMOVAL).axes[0]
    flat = {
        round(float(line.get_ydata()[0]), 6)
        for line in axes.get_lines()
        if len(line.get_xdata()) == 2
    }
    assert {round(float(np.degrees(np.arctan(mu))), 6) for mu in (0.6, 0.8)} <= flat


def test_disc_path_is_the_share_of_the_cone(plan):
    disc = plotting.force_in_cone(plan, "02_addition", "thumb").axes[1]
    path = np.column_stack(disc.get_lines()[0].get_data())
    phase = plan.phases[2]
    track = phase.contacts["thumb"]
    from pivotgait.contacts import friction_margin

    margin = friction_margin(track.force, track.world_normal(phase.tool), track.friction)
    np.testing.assert_allclose(np.linalg.norm(path, axis=1), 1.0 - margin, atol=1e-12)


def test_pictures_of_a_row_share_their_scale(plan):
    figure = plotting.tool_snapshots(plan, REMOVAL)
    assert len(figure.axes) == 6
    for row in (figure.axes[:3], figure.axes[3:]):
        assert len({(axes.get_xlim(), axes.get_ylim()) for axes in row}) == 1
        assert all(axes.get_aspect() == 1.0 for axes in row)


def test_close_ups_tell_every_force(plan):
    texts = [text.get_text() for text in plotting.tool_snapshots(plan, REMOVAL).axes[3].texts]
    track = plan.phases[-1].contacts["thumb"]
    assert f"thumb\n{np.linalg.norm(track.force[0]):.1f} N" in texts
    assert any(text.endswith(" N") and text[0].isdigit() for text in texts), "no scale of forces"


def test_strip_shows_the_start_and_the_end_of_every_phase(plan):
    shown = [axes for axes in plotting.gait_strip(plan).axes if axes.get_title()]
    assert len(shown) == len(plan.phases) + 1
    assert shown[-1].get_title() == "removal index\n2.70 s"


@pytest.mark.parametrize("make", [plotting.tool_snapshots, plotting.angle_to_normal])
def test_unknown_phase_lists_the_known(make, plan):
    with pytest.raises(UnknownNameError, match="03_removal"):
        make(plan, "03_remove")


def test_unknown_contact_lists_the_known(plan):
    with pytest.raises(UnknownNameError, match="thumb"):
        plotting.force_in_cone(plan, "00_lift", "middle")


def test_matplotlibs_own_settings_and_pyplot_stay_untouched(plan):
    before = dict(mpl.rcParams)
    plotting.figure_bytes(plotting.overview(plan), "png")
    assert dict(mpl.rcParams) == before


def test_plotting_never_loads_pyplot():
    code = "import sys, pivotgait.plotting; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
