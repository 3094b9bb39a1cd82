"""Contact forces of a run beside those of its plan: how hard, and how near to slipping."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.contacts.cone import split_force
from pivotgait.frozen import Array
from pivotgait.plans.plan import PIVOT, GaitPlan
from pivotgait.plotting.forces import draw_bounds
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.run_axes import draw_pair, shade_run, since_start
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    contact_names,
    new_figure,
    styled,
)
from pivotgait.validation.record_reading import RecordedMotion

LEAST_LOAD_N = 0.05
"""Below this normal force a simulated contact chatters: its force has no direction to speak of."""
_UP = np.array([0.0, 0.0, 1.0])


class _Contact(NamedTuple):
    """A contact at the N rows of a run, NaN or 0 where the plan has none.

    Forces are on the tool: in the tool frame for a finger, in the world for the pivot [N].
    """

    planned: Array
    measured: Array
    normal: Array
    friction: Array


@styled
def run_normal_forces(plan: GaitPlan, motion: RecordedMotion) -> Any:
    """Measured normal force of every contact upon the planned one, a panel for each.

    Args:
        plan: that was carried out.
        motion: the record of its run.

    Returns:
        A matplotlib ``Figure`` of page width.
    """

    def draw(axes: Any, name: str, contact: _Contact, colour: str) -> list[EndLabel]:
        pair = [np.sum(f * contact.normal, axis=-1) for f in (contact.planned, contact.measured)]
        labels = draw_pair(axes, motion, pair[0], pair[1], colour)
        shown = since_start(motion, np.maximum(pair[0], pair[1]))[1]
        axes.set_ylim(0.0, 1.25 * float(shown.max()) or 1.0)
        return labels + draw_bounds(axes, plan, [name])

    return _panels(plan, motion, "normal\nforce [N]", draw)


@styled
def run_angles(plan: GaitPlan, motion: RecordedMotion) -> Any:
    """Angle of every measured force to its normal upon the planned one, and the friction cone's.

    Normals are the planned ones, turned with the real tool. A force below 0.05 N has no angle.
    Arguments and result as :func:`run_normal_forces`.
    """

    def draw(axes: Any, name: str, contact: _Contact, colour: str) -> list[EndLabel]:
        pair = [_angle(f, contact.normal) for f in (contact.planned, contact.measured)]
        labels = draw_pair(axes, motion, pair[0], pair[1], colour)
        limit = np.where(contact.friction > 0.0, np.degrees(np.arctan(contact.friction)), np.nan)
        axes.plot(*since_start(motion, limit), color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
        tops = [float(np.nanmax(each)) for each in (limit, *pair) if np.isfinite(each).any()]
        axes.set_ylim(0.0, 1.12 * max(tops, default=1.0))
        cone = [float(each) for each in limit[np.isfinite(limit)][-1:]]  # none if it never came
        return labels + [EndLabel(f"slips ≥ {each:.1f}°", each, LIMIT_COLOUR) for each in cone]

    return _panels(plan, motion, "angle to the\nnormal [deg]", draw)


def _panels(
    plan: GaitPlan,
    motion: RecordedMotion,
    label: str,
    draw: Callable[[Any, str, _Contact, str], list[EndLabel]],
) -> Any:
    """One panel for each contact of the plan; ``draw`` fills it and tells its labels."""
    colours = contact_colours(plan)
    planned = {name for phase in plan.phases for name in phase.contacts}
    names = [name for name in contact_names(plan) if name in planned and name != PIVOT]
    names = [name for name in names if name in motion.series.fingers] + [PIVOT]
    figure = new_figure(PAGE_WIDTH, 0.55 + 1.0 * len(names))
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for number, (axes, name) in enumerate(zip(panels, names, strict=True)):
        shade_run(axes, plan, motion, named=number == 0)
        labels = draw(axes, name, _contact(motion, name), colours[name])
        axes.set_ylabel(f"{name}\n{label}")
        label_right(axes, labels)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel("time [s]")
    return figure


def _contact(motion: RecordedMotion, name: str) -> _Contact:
    series, planned = motion.series, motion.planned
    if name == PIVOT:
        normal = np.broadcast_to(_UP, series.pivot_force.shape)
        return _Contact(planned.pivot_force, series.pivot_force, normal, planned.pivot_friction)
    k = series.fingers.index(name)
    turn = Rotation.from_quat(series.tool_orientation).as_matrix()
    in_tool = np.einsum("nji,nj->ni", turn, series.force[:, k])
    return _Contact(planned.force[:, k], in_tool, planned.normal[:, k], planned.friction[:, k])


def _angle(force: Array, normal: Array) -> Array:
    """(N,) angles [deg]; NaN where the contact bears next to nothing."""
    along, across = split_force(force, normal)
    return np.where(along > LEAST_LOAD_N, np.degrees(np.arctan2(across, along)), np.nan)
