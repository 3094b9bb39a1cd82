"""Figures of a run: its curves beside the plan's, its limits, its poses."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from pivotgait import plotting
from pivotgait.plotting.run_replay import held
from pivotgait.plotting.timeline import spans
from pivotgait.validation.metrics import normal_forces
from pivotgait.validation.verdict import Rule

DRAWINGS = {
    "forces": plotting.run_normal_forces,
    "angles": plotting.run_angles,
    "deviations": plotting.run_deviations,
    "torques": plotting.run_torques,
}


def until(motion, end):
    """The same run broken off at ``end`` [s]."""
    rows = motion.series.time <= end

    def cut(record):
        found = {n: v[rows] for n, v in vars(record).items() if np.shape(v)[:1] == rows.shape}
        return replace(record, **found)

    slips = {name: slip[rows] for name, slip in motion.fingertip_slips.items()}
    whole = replace(motion, series=cut(motion.series), planned=cut(motion.planned))
    short = {n: getattr(motion, n)[rows] for n in ("tip_slip", "orientation_error", "torque_share")}
    return replace(whole, fingertip_slips=slips, **short)


def lines(axes, label):
    return [line for line in axes.get_lines() if line.get_label() == label]


@pytest.mark.parametrize("name", DRAWINGS)
def test_axes_name_units_phases_and_the_hold(name, robot_plan, motion):
    figure = DRAWINGS[name](robot_plan, motion)
    assert figure.get_figwidth() == plotting.PAGE_WIDTH
    figure.draw_without_rendering()
    assert all(axes.get_ylabel().endswith("]") for axes in figure.axes)
    assert figure.axes[-1].get_xlabel().endswith("time [s]")
    words = {text.get_text().replace("\n", " ") for text in figure.axes[0].texts}
    assert {"lift", "relocation middle", "removal index", "final hold"} <= words
    assert figure.axes[0].get_xlim() == (0.0, pytest.approx(motion.series.time[-1]))
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 7.0
    page = figure.bbox.padded(2.0)
    for text in (text for axes in figure.axes for text in axes.texts):
        box = text.get_window_extent()
        assert page.x0 <= box.x0, text.get_text()
        assert box.x1 <= page.x1, text.get_text()


@pytest.mark.parametrize("name", DRAWINGS)
@pytest.mark.parametrize("end", [0.05, 1.5])
def test_a_run_broken_off_keeps_the_plans_time_axis(name, end, robot_plan, motion):
    figure = DRAWINGS[name](robot_plan, until(motion, end))
    figure.draw_without_rendering()
    assert figure.axes[0].get_xlim()[1] == pytest.approx(spans(robot_plan)[-1].end)


def test_each_contact_has_a_panel_with_both_forces(robot_plan, motion):
    figure = plotting.run_normal_forces(robot_plan, motion)
    names = [axes.get_ylabel().split("\n")[0] for axes in figure.axes]
    assert names == ["thumb", "index", "middle", "pivot"]
    begun = motion.series.time >= 0.0
    along = normal_forces(motion.series, motion.planned)[begun]
    for axes, name in zip(figure.axes[:3], names, strict=False):
        (measured,), (planned,) = lines(axes, "measured"), lines(axes, "planned")
        place = motion.series.fingers.index(name)
        np.testing.assert_allclose(measured.get_ydata(), along[:, place], atol=1e-12)
        np.testing.assert_array_equal(
            planned.get_ydata(), motion.planned.normal_force[begun, place]
        )
        assert measured.get_color() == plotting.contact_colours(robot_plan)[name]
    (pivot,) = lines(figure.axes[3], "measured")
    np.testing.assert_array_equal(pivot.get_ydata(), motion.series.pivot_force[begun, 2])


def test_angles_are_the_planned_ones_of_a_faithful_run_and_below_the_cone(robot_plan, motion):
    figure = plotting.run_angles(robot_plan, motion)
    seen = 0
    for axes in figure.axes:
        (measured,), (planned,) = lines(axes, "measured"), lines(axes, "planned")
        np.testing.assert_allclose(measured.get_ydata(), planned.get_ydata(), atol=1e-6)
        known = measured.get_ydata()[np.isfinite(measured.get_ydata())]
        seen += len(known)
        assert axes.get_ylim()[1] >= max(known, default=0.0)
    assert seen > 100
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    for friction in (0.6, 0.8):
        assert f"slips ≥ {np.degrees(np.arctan(friction)):.1f}°" in texts


def test_a_turned_force_shows_its_angle(robot_plan, motion):
    pivot = np.array([0.3, 0.4, 1.0])
    series = replace(motion.series, pivot_force=np.tile(pivot, (len(motion.series.time), 1)))
    figure = plotting.run_angles(robot_plan, replace(motion, series=series))
    (measured,) = lines(figure.axes[-1], "measured")
    np.testing.assert_allclose(measured.get_ydata(), np.degrees(np.arctan2(0.5, 1.0)))


def test_limits_of_the_rule_are_drawn_and_no_curve_is_cut(robot_plan, motion):
    rule = Rule(tip_slip_m=2e-3, fingertip_slip_m=4e-3, orientation_deg=7.0)
    far = replace(motion, tip_slip=10.0 * motion.tip_slip)
    figure = plotting.run_deviations(robot_plan, far, rule)
    for axes, limit in zip(figure.axes, (2.0, 4.0, 7.0), strict=True):
        drawn = [np.unique(line.get_ydata()) for line in axes.get_lines()]
        assert any(len(y) == 1 and y[0] == pytest.approx(limit) for y in drawn)
        top = max(np.nanmax(line.get_ydata()) for line in axes.get_lines())
        assert axes.get_ylim()[1] > top
    (tip,) = lines(figure.axes[0], "tip")
    assert tip.get_ydata()[-1] == pytest.approx(1e3 * far.tip_slip[-1])


def test_a_finger_away_from_the_tool_has_no_slip(robot_plan, motion):
    place = motion.series.fingers.index("middle")
    free = motion.planned.free[:, place] > 0.0
    slips = {n: np.where(free & (n == "middle"), 0.0, s) for n, s in motion.fingertip_slips.items()}
    figure = plotting.run_deviations(robot_plan, replace(motion, fingertip_slips=slips))
    (line,) = lines(figure.axes[1], "middle")
    begun = motion.series.time >= 0.0
    np.testing.assert_array_equal(np.isnan(line.get_ydata()), free[begun])


def test_torques_are_those_of_the_run(robot_plan, motion):
    figure = plotting.run_torques(robot_plan, motion)
    begun = motion.series.time >= 0.0
    for place, name in enumerate(motion.series.joint_names):
        (line,) = (line for axes in figure.axes for line in lines(axes, name))
        np.testing.assert_array_equal(line.get_ydata(), motion.torque_share[begun, place])


def test_a_replay_has_the_runs_places_and_forces(robot_plan, motion):
    shift = np.array([0.001, 0.002, 0.0])
    series = replace(
        motion.series,
        tool_position=motion.series.tool_position + shift,
        q=motion.series.q + 0.01,
        pivot_force=2.0 * motion.series.pivot_force,
    )
    run = plotting.replay(robot_plan, replace(motion, series=series))
    assert run.certificate is None
    for ours, theirs in zip(run.phases, robot_plan.phases, strict=True):
        # rows of the record lie between samples of the plan
        np.testing.assert_allclose(ours.tool.position, theirs.tool.position + shift, atol=2e-4)
        np.testing.assert_allclose(ours.robot.q, theirs.robot.q + 0.01, atol=2e-3)
        turn = ours.tool.rotation.inv() * theirs.tool.rotation
        assert np.degrees(turn.magnitude()).max() < 0.1
        pivot = ours.contacts["pivot"].force
        np.testing.assert_allclose(pivot, 2.0 * theirs.contacts["pivot"].force, atol=0.05)


def test_a_replay_ends_where_the_run_did(robot_plan, motion):
    ends = [span.end for span in spans(robot_plan)]
    short = until(motion, ends[1] + 0.1)
    run = plotting.replay(robot_plan, short)
    assert len(run.phases) == 3
    assert run.phases[2].duration_s <= 0.1
    assert all(len(track.force) == len(run.phases[2].time)
               for track in run.phases[2].contacts.values())  # fmt: skip
    assert held(robot_plan, short) is None
    assert held(robot_plan, motion).tool.position.shape == (1, 3)


@pytest.mark.parametrize(("end", "pictures"), [(9.0, 6), (1.0, 3)])
def test_the_strip_shows_every_phase_and_the_hold(end, pictures, robot_plan, motion):
    figure = plotting.run_strip(robot_plan, until(motion, end), columns=3)
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert len(titles) == pictures
    assert ("final hold" in titles[-1]) == (end > 3.0)
