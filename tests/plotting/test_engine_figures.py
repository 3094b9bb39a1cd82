"""Figures of several engines: each one's curves beside the plan's."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from pivotgait import plotting
from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.plotting.engine_study import conclusions_grid, removal_in_engines
from pivotgait.validation.metrics import normal_forces


@pytest.fixture
def motions(motion):
    pressed = replace(motion.series, force=1.1 * motion.series.force)
    return {"pybullet": motion, "mujoco": replace(motion, series=pressed)}


def texts(figure):
    return [text for text in figure.findobj(mpl.text.Text) if text.get_text()]


def removal(plan):
    return next(phase.name for phase in plan.phases if phase.kind == "removal")


def test_forces_of_both_engines_lie_on_the_plan(robot_plan, motions):
    figure = plotting.comparison(robot_plan, motions)
    assert figure.get_figwidth() == plotting.PAGE_WIDTH
    figure.draw_without_rendering()
    assert all(axes.get_ylabel().endswith("]") for axes in figure.axes)
    assert figure.axes[-1].get_xlabel() == "time [s]"
    first = motions["pybullet"].series
    place, begun = first.fingers.index("thumb"), first.time >= 0.0
    plan, *runs = figure.axes[0].get_lines()
    planned = motions["pybullet"].planned.normal_force[begun, place]
    np.testing.assert_array_equal(plan.get_ydata(), planned)
    for line, motion in zip(runs, motions.values(), strict=True):
        along = normal_forces(motion.series, motion.planned)[begun, place]
        np.testing.assert_allclose(line.get_ydata(), along)
    assert runs[0].get_linestyle() != runs[1].get_linestyle()
    words = {text.get_text() for text in texts(figure)}
    assert {"plan", "PyBullet", "MuJoCo", "thumb", "index", "middle"} <= words
    assert min(text.get_fontsize() for text in texts(figure)) >= 7.0


def test_too_many_engines_are_refused(robot_plan, motion):
    with pytest.raises(InputError, match="0 engines"):
        plotting.comparison(robot_plan, {})
    with pytest.raises(InputError, match="4 engines"):
        plotting.comparison(robot_plan, dict.fromkeys("abcd", motion))


def test_a_removal_has_a_column_for_the_plan_and_each_engine(robot_plan, motions):
    figure = removal_in_engines(robot_plan, removal(robot_plan), motions)
    figure.draw_without_rendering()
    above, below = figure.axes[:3], figure.axes[3:]
    assert [axes.get_title() for axes in above] == ["plan", "PyBullet", "MuJoCo"]
    assert len({axes.get_ylim() for axes in above}) == 1
    paths = [max(axes.get_lines(), key=lambda line: len(line.get_xdata())) for axes in above]
    one, two = (path.get_ydata() for path in paths[1:])
    np.testing.assert_allclose(two, 1.1 * one)
    # a scaled force has the same angle
    for left, right in zip(below[1].get_lines(), below[2].get_lines(), strict=True):
        mine, theirs = left.get_ydata(), right.get_ydata()
        both = np.isfinite(mine) & np.isfinite(theirs)
        np.testing.assert_allclose(np.asarray(mine)[both], np.asarray(theirs)[both], atol=1e-5)


@pytest.mark.parametrize(("name", "error"), [("nothing", UnknownNameError), (None, InputError)])
def test_only_phases_with_a_changing_contact(robot_plan, motions, name, error):
    with pytest.raises(error):
        removal_in_engines(robot_plan, name or robot_plan.phases[0].name, motions)


def test_each_engine_has_its_field():
    holds = {
        "pybullet": np.array([[1.0, 0.0], [1.0, np.nan]]),
        "mujoco": np.array([[1.0, 1.0], [0.0, np.nan]]),
    }
    figure = conclusions_grid(["usual", "hard"], ["holds", "slips"], holds)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    marks = [text.get_text() for text in axes.texts]
    assert sorted(marks) == sorted("✓" * 4 + "✗" * 2)
    lefts = {text.get_position()[0] for text in axes.texts if text.get_position()[1] == 1}
    assert len(lefts) == 2
    assert "PyBullet, MuJoCo" in axes.get_xlabel()
