"""Figures of the arm-hand: its hand in the film strip, its joints within their limits."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex

from pivotgait import plotting
from pivotgait.exceptions import InputError
from pivotgait.margins import joint_shares, largest_share
from pivotgait.plotting.picture import TIP_RADIUS, Moment, look_at, tip_radii
from pivotgait.plotting.robot import part_colours, robot_surfaces
from pivotgait.plotting.style import contact_colours

JOINTS = {
    "range": plotting.joint_positions,
    "speed": plotting.joint_speeds,
    "torque": plotting.joint_torques,
}
DRAWINGS = {"gait_strip": plotting.gait_strip, "robot_scene": plotting.robot_scene}


@pytest.mark.parametrize("kind", JOINTS)
def test_curves_are_the_shares_of_every_joint(kind, robot_plan):
    figure = JOINTS[kind](robot_plan)
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    column = {name: k for k, name in enumerate(robot_plan.robot.joint_names)}
    drawn = {}
    for line in lines:
        if line.get_label() in column:
            drawn.setdefault(line.get_label(), []).append(line.get_ydata())
    assert set(drawn) == set(column)
    for name, curves in drawn.items():
        for curve, shares in zip(curves, joint_shares(robot_plan), strict=True):
            np.testing.assert_array_equal(curve, shares.of(kind)[:, column[name]])


@pytest.mark.parametrize("kind", JOINTS)
def test_axes_name_units_phases_and_letters_are_readable(kind, robot_plan):
    figure = JOINTS[kind](robot_plan)
    assert figure.get_figwidth() == plotting.PAGE_WIDTH
    figure.draw_without_rendering()
    assert all(axes.get_ylabel().endswith("[-]") for axes in figure.axes)
    assert figure.axes[-1].get_xlabel().endswith("time [s]")
    words = {text.get_text().replace("\n", " ") for text in figure.axes[0].texts}
    assert {"lift", "relocation middle", "removal index"} <= words
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 7.0
    page = figure.bbox.padded(2.0)
    for text in (text for axes in figure.axes for text in axes.texts):
        box = text.get_window_extent()
        assert page.x0 <= box.x0, text.get_text()
        assert box.x1 <= page.x1, text.get_text()


def test_the_largest_share_is_marked_at_its_place(robot_plan):
    figure = plotting.joint_torques(robot_plan)
    found = largest_share(robot_plan, "torque")
    marks = [line for a in figure.axes for line in a.get_lines() if line.get_marker() == "o"]
    assert [abs(float(mark.get_ydata()[0])) for mark in marks] == [found.value]
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert any(found.joint in text and f"{found.value:.2f}" in text for text in texts)


@pytest.mark.parametrize(("factor", "seen"), [(0.1, False), (2.0, True), (3.0, True)])
def test_limits_are_seen_or_said_to_lie_beyond(factor, seen, robot_plan):
    phases = tuple(
        replace(phase, robot=replace(phase.robot, tau=factor * phase.robot.tau))
        for phase in robot_plan.phases
    )
    figure = plotting.joint_torques(replace(robot_plan, phases=phases))
    _, top = figure.axes[0].get_ylim()
    assert (top > 1.0) == seen
    assert top >= 0.4 * factor, "no curve is cut"
    assert ("beyond" in figure.axes[-1].get_xlabel()) is not seen


@pytest.mark.parametrize("draw", [*JOINTS.values(), plotting.robot_scene])
def test_a_plan_without_a_robot_says_so(draw, plan):
    with pytest.raises(InputError, match="no robot"):
        draw(plan)


@pytest.mark.parametrize("name", DRAWINGS)
def test_drawings_fit_a_paper(name, robot_plan):
    figure = DRAWINGS[name](robot_plan)
    assert figure.get_figwidth() in (plotting.COLUMN_WIDTH, plotting.PAGE_WIDTH)
    figure.draw_without_rendering()
    sizes = [t.get_fontsize() for t in figure.findobj(mpl.text.Text) if t.get_text()]
    assert min(sizes) >= 7.0
    assert all(axes.get_aspect() == 1.0 for axes in figure.axes if axes.collections)


def test_fingers_have_their_colour_and_the_arm_is_lighter_than_the_hand(robot_plan):
    colours = contact_colours(robot_plan)
    body = robot_surfaces(robot_plan).skeleton
    found = part_colours(body, colours)
    assert found["fftip"] == colours["index"]
    assert found["thtip"] == colours["thumb"]
    assert len({found["ffproximal"], found["ffmiddle"], found["mfmiddle"]}) == 2
    light = {name: sum(mpl.colors.to_rgb(found[name])) for name in ("forearm", "palm")}
    assert light["forearm"] > 2 * light["palm"]


def test_the_strip_shows_the_hand_without_the_arm(robot_plan):
    moment = Moment(robot_plan.phases[0], 0)
    look = look_at(robot_plan, [moment], hand=True)
    assert {"palm", "thtip"} <= set(look.hand.links)
    assert "forearm" not in look.hand.links
    with_hand, without = (
        sum(len(s.faces) for s in each.bodies(moment))
        for each in (look, look_at(robot_plan, [moment]))
    )
    assert with_hand > without
    tips = [s for s in look.bodies(moment) if to_hex(s.colour) == look.colours["index"].lower()]
    assert len(tips) == 1


def test_tips_are_as_large_as_the_plan_says(robot_plan, plan):
    assert tip_radii(robot_plan)["thumb"] == 0.0075
    assert tip_radii(robot_plan)["index"] == 0.006
    assert set(tip_radii(plan).values()) == {TIP_RADIUS}
