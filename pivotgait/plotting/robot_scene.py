"""The whole arm-hand at its table."""

from __future__ import annotations

from typing import Any

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.ground import draw_ground
from pivotgait.plotting.picture import Moment, look_at
from pivotgait.plotting.render import Camera, paint
from pivotgait.plotting.robot import middle_of, robot_surfaces
from pivotgait.plotting.style import COLUMN_WIDTH, new_figure, styled
from pivotgait.plotting.timeline import phase_title

_LARGEST_FACE = 0.012
_ASIDE, _ELEVATION = (float(angle) for angle in np.radians((62.0, 18.0)))
_BAR = 0.2


@styled
def robot_scene(plan: GaitPlan, *, width: float = COLUMN_WIDTH) -> Any:
    """The whole arm-hand with tool and table, at the end of the first phase.

    Args:
        plan: a gait with a robot.
        width: of the figure [in].

    Returns:
        A matplotlib ``Figure``.

    Raises:
        InputError: if the plan, or its first phase, has no robot.
        UrdfError: if the robot's URDF is broken.
    """
    first = plan.phases[0]
    robot = robot_surfaces(plan, largest_face=_LARGEST_FACE)
    if robot is None or first.robot is None:
        raise InputError("has no robot", where="plan", mend="plan a scene with a robot")
    moment = Moment(first, len(first.time) - 1)
    arm = robot.placed(first.robot.q[-1])
    bodies = look_at(plan, [moment]).bodies(moment) + arm
    points = np.concatenate([surface.faces.reshape(-1, 3) for surface in bodies])
    camera = _beside(middle_of(arm[:1]), moment.position)
    flat = camera.project(points)[:, :2]
    low, high = flat.min(axis=0) - 0.04, flat.max(axis=0) + 0.04
    figure = new_figure(width, 0.25 + width * (high[1] - low[1]) / (high[0] - low[0]))
    axes = figure.subplots()
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    draw_ground(axes, camera, plan.table_height, bodies)
    paint(axes, camera, bodies)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"{plan.tool.name}, end of {phase_title(first)}")
    _draw_bar(axes, low)
    return figure


def _beside(base: Array, tool: Array) -> Camera:
    """A camera that sees the robot's base on the left and the tool on the right, nearer to it."""
    away = tool - base
    return Camera.looking_from(float(np.arctan2(away[1], away[0])) - _ASIDE, _ELEVATION)


def _draw_bar(axes: Any, corner: Array) -> None:
    start = corner + 0.03
    axes.plot([start[0], start[0] + _BAR], [start[1]] * 2, color="#222222", lw=1.5, zorder=6)
    axes.annotate(
        f"{1000 * _BAR:g} mm",
        (start[0] + _BAR, start[1]),
        xytext=(4, 0),
        textcoords="offset points",
        va="center",
        fontsize=7,
        zorder=6,
    )
