"""Orientation and angular speed of the tool over a gait."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.style import PAGE_WIDTH, new_figure, styled
from pivotgait.plotting.timeline import shade_phases, spans

_ANGLES = (("yaw", ":"), ("pitch", "-"), ("roll", "--"))
_INK = "#333333"


@styled
def orientation(plan: GaitPlan) -> Any:
    """How far the tool has turned since the gait began, and how fast it turns.

    Angles are those of ``R = Rz(yaw) Ry(pitch) Rx(roll)``, the turn from the first orientation,
    on axes that look along the table from the tool to its tip, to the left and up. However the
    tool lay, pitch says how far its handle has risen, roll how far it has turned about its
    length. A figure of page width.
    """
    figure = new_figure(PAGE_WIDTH, 3.0)
    angles, speed = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    draw_angles(angles, plan)
    draw_speed(speed, plan)
    speed.set_xlabel("time [s]")
    return figure


def draw_angles(axes: Any, plan: GaitPlan, *, named: bool = True) -> None:
    """Yaw, pitch and roll since the start [deg] on ``axes``."""
    shade_phases(axes, plan, named=named)
    start = plan.phases[0].tool.rotation[0]
    ahead = start.as_matrix() @ plan.tool.pivot_in_tool
    heading = Rotation.from_euler("z", np.arctan2(ahead[1], ahead[0]))
    labels = []
    for span in spans(plan):
        turn = heading.inv() * span.phase.tool.rotation * start.inv() * heading
        turned = turn.as_euler("ZYX", degrees=True)
        for (_, dashes), angle in zip(_ANGLES, turned.T, strict=True):
            axes.plot(span.time, angle, color=_INK, ls=dashes)
        labels = [
            EndLabel(name, float(angle), _INK)
            for (name, _), angle in zip(_ANGLES, turned[-1], strict=True)
        ]
    axes.margins(y=0.1)
    axes.set_ylabel("turn since\nstart [deg]")
    label_right(axes, labels)


def draw_speed(axes: Any, plan: GaitPlan, *, named: bool = False) -> None:
    """Magnitude of the angular velocity [deg/s] on ``axes``."""
    shade_phases(axes, plan, named=named)
    for span in spans(plan):
        speed = np.degrees(np.linalg.norm(span.phase.tool.angular_velocity, axis=1))
        axes.plot(span.time, speed, color=_INK)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("angular\nspeed [deg/s]")
