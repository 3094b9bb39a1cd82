"""The whole gait on one page: forces, margins and motion over one time axis."""

from __future__ import annotations

from typing import Any

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.forces import draw_finger_forces, draw_pivot_force
from pivotgait.plotting.margins import draw_margins
from pivotgait.plotting.orientation import draw_angles, draw_speed
from pivotgait.plotting.style import PAGE_WIDTH, new_figure, styled


@styled
def overview(plan: GaitPlan) -> Any:
    """Normal forces, friction margins, orientation and angular speed, phases named on top.

    A figure of page width.
    """
    figure = new_figure(PAGE_WIDTH, 6.6)
    panels = figure.subplots(5, 1, sharex=True, height_ratios=(3, 2, 3, 3, 2))
    draws = (draw_finger_forces, draw_pivot_force, draw_margins, draw_angles, draw_speed)
    for number, (panel, draw) in enumerate(zip(panels, draws, strict=True)):
        draw(panel, plan, named=number == 0)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel("time [s]")
    return figure
