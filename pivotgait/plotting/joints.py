"""Joints of the arm-hand over a gait, each as a share of its limits, by finger and palm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.margins.joints import ShareKind, joint_shares
from pivotgait.plans.plan import GaitPlan, PlannedRobot
from pivotgait.plotting.labels import EndLabel, label_right
from pivotgait.plotting.posture import skeleton
from pivotgait.plotting.style import (
    LIMIT_COLOUR,
    PAGE_WIDTH,
    contact_colours,
    mixed,
    new_figure,
    styled,
)
from pivotgait.plotting.timeline import shade_phases, spans

PALM = "arm and wrist"
_PALM_COLOUR = "#3A3D40"
_BEYOND = "#F3D9CF"
_PALEST = 0.55
"""Share of white in the colour of the outermost joint."""
_DASHES: Sequence[Any] = ("-", (0, (5, 1.5)), (0, (1, 1)), "-", (0, (5, 1.5)), (0, (1, 1)))
_REACHES = (0.12, 0.25, 0.5, 1.15)
"""Ends of the axis to choose from: the smallest that holds the curves."""


class JointCurve(NamedTuple):
    """Shares of a joint (N,) over times of the gait (N,) [s]."""

    time: Array
    share: Array

    @property
    def largest(self) -> float:
        """Largest magnitude."""
        return float(np.max(np.abs(self.share)))


@styled
def joint_positions(plan: GaitPlan) -> Any:
    """Every joint's place between its lower limit (-1) and its upper one (1) over the gait.

    Panels are the arm with the wrist, and each finger; what lies beyond the limits is shaded.

    Args:
        plan: a gait with a robot.

    Returns:
        A matplotlib ``Figure`` of page width.

    Raises:
        InputError: if the plan has no robot.
        UrdfError: if the robot's URDF is broken.
    """
    return _draw_all(plan, "range", "place in\nrange [-]")


@styled
def joint_speeds(plan: GaitPlan) -> Any:
    """Every joint's velocity over its limit; panels and errors as :func:`joint_positions`."""
    return _draw_all(plan, "speed", "speed /\nlimit [-]")


@styled
def joint_torques(plan: GaitPlan) -> Any:
    """Every joint's torque or force over its limit (Xue et al., eq. 17).

    Panels and errors as :func:`joint_positions`.
    """
    return _draw_all(plan, "torque", "torque /\nlimit [-]")


def _draw_all(plan: GaitPlan, kind: ShareKind, label: str) -> Any:
    reach = 1.15 if kind == "range" else None
    return draw_joints(plan, _curves(plan, kind), label, reach=reach)


def draw_joints(
    plan: GaitPlan,
    curves: Mapping[str, Sequence[JointCurve]],
    label: str,
    *,
    reach: float | None = None,
    end: float | None = None,
) -> Any:
    """Shares of all joints in panels of arm and wrist, and each finger; the largest is marked.

    Args:
        plan: a gait with a robot.
        curves: joint's name -> its curves one after the other.
        label: of the vertical axes.
        reach: where these end; by default such that all curves are seen.
        end: of the time axis [s], if it is not the plan's.

    Raises:
        InputError: if the plan has no robot.
        UrdfError: if the robot's URDF is broken.
    """
    robot = _robot_of(plan)
    body = skeleton(robot)
    groups = {name: body.joints_of(name) for name in (PALM, *robot.fingers)}
    groups = {name: joints for name, joints in groups.items() if joints}
    colours = {PALM: _PALM_COLOUR} | contact_colours(plan)
    most = max((each for joint in curves.values() for each in joint), key=lambda c: c.largest)
    reach = reach or _reach(most.largest)
    figure = new_figure(PAGE_WIDTH, 0.55 + 1.0 * len(groups))
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    for number, (panel, (name, joints)) in enumerate(zip(panels, groups.items(), strict=True)):
        shade_phases(panel, plan, named=number == 0, end=end)
        _shade_limits(panel, reach)
        _draw_group(panel, {joint: curves[joint] for joint in joints}, colours[name])
        panel.set_ylabel(f"{name}\n{label}")
        for joint in joints:
            if any(each is most for each in curves[joint]):
                _mark(panel, joint, most)
    figure.align_ylabels(panels)
    beyond = "the limits, ±1, lie beyond these axes; " if reach < 1.0 else ""
    panels[-1].set_xlabel(f"{beyond}time [s]")
    return figure


def _robot_of(plan: GaitPlan) -> PlannedRobot:
    if plan.robot is None:
        raise InputError("has no robot", where="plan", mend="plan a scene with a robot")
    return plan.robot


def _curves(plan: GaitPlan, kind: ShareKind) -> dict[str, list[JointCurve]]:
    """Every joint's curves, one for each phase."""
    names = _robot_of(plan).joint_names
    found: dict[str, list[JointCurve]] = {}
    for span, shares in zip(spans(plan), joint_shares(plan), strict=True):
        for name, curve in zip(names, shares.of(kind).T, strict=True):
            found.setdefault(name, []).append(JointCurve(span.time, curve))
    return found


def _reach(largest: float) -> float:
    return next((reach for reach in _REACHES if 1.1 * largest <= reach), 1.1 * largest)


def _shade_limits(axes: Any, reach: float) -> None:
    for sign in (-1.0, 1.0):
        axes.axhspan(sign, sign * max(reach, 1.0), color=_BEYOND, lw=0, zorder=0.5)
        axes.axhline(sign, color=LIMIT_COLOUR, lw=0.8, ls=(0, (4, 3)))
    axes.set_ylim(-reach, reach)


def _draw_group(axes: Any, joints: Mapping[str, Sequence[JointCurve]], colour: str) -> None:
    """Curves of some joints, paler from the base outwards, named at their ends."""
    labels = []
    for place, (name, phases) in enumerate(joints.items()):
        shade = mixed(colour, _PALEST * place / max(len(joints) - 1, 1))
        for curve in phases:
            axes.plot(*curve, color=shade, ls=_DASHES[place % len(_DASHES)], lw=1.1, label=name)
        labels.append(EndLabel(name, float(phases[-1].share[-1]), shade))
    label_right(axes, labels)


def _mark(axes: Any, joint: str, curve: JointCurve) -> None:
    """Mark and name the largest share, inwards from its place."""
    sample = int(np.argmax(np.abs(curve.share)))
    time, value = float(curve.time[sample]), float(curve.share[sample])
    late, high = time > 0.6 * axes.get_xlim()[1], value > 0.0
    axes.plot(time, value, "o", ms=3.5, color=LIMIT_COLOUR, clip_on=False, zorder=5)
    axes.annotate(
        f"largest: {curve.largest:.2f}, {joint}, {time:.2f} s",
        (time, value),
        xytext=(-6 if late else 6, -5 if high else 5),
        textcoords="offset points",
        ha="right" if late else "left",
        va="top" if high else "bottom",
        fontsize=7,
        color=LIMIT_COLOUR,
        bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 0.8},
    )
