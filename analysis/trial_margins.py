"""Margins that a plan keeps in a world that is not as planned: what a trial's draw leaves of it.

The margin of a draw is the least share by which all friction could drop, over the moments of
every phase (middle, weakest, end), such that contact forces still hold the tool on its planned
motion, with the drawn mass, friction, places and width of the handle:

* **free**: forces may be allocated anew, as if everything were known;
* **held**: each finger presses with the normal force that the controller believes in, the
  planned one over the drawn gain of its sensor; tangential forces and the table make up the rest.

Both are 1 for a grasp that needs no friction, 0 at its edge, negative beyond.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pivotgait.contacts.cone import split_force
from pivotgait.dynamics import PivotingTool
from pivotgait.feasibility import Grasps, friction_drop
from pivotgait.feasibility.moments import moments_of
from pivotgait.frozen import Array
from pivotgait.models import Robot, Scene
from pivotgait.phases.grasp import Setting
from pivotgait.plans import PIVOT, GaitPlan, Phase
from pivotgait.validation.perturbation import Perturbation

LOWEST = -30.0
"""Stands for minus infinity: no amount of friction helps."""


@dataclass(frozen=True, eq=False)
class Held:
    """The moments of one phase.

    Attributes:
        phase: its name.
        grasps: as planned, whole friction.
        normal: (B, m) planned normal forces [N].
    """

    phase: str
    grasps: Grasps
    normal: Array


class PlanMargins:
    """Margins of a plan under draws.

    Args:
        plan: with or without a robot.
        scene: it was made from.
    """

    def __init__(self, plan: GaitPlan, scene: Scene) -> None:
        body = Setting.of(scene).body
        self.moments = [_held(p, body) for p in plan.phases if p.kind != "relocation"]

    def margin(self, draw: Perturbation, *, held: bool = False) -> float:
        """The least margin over all phases, see the module's text."""
        return min(self.by_phase(draw, held=held).values())

    def by_phase(self, draw: Perturbation, *, held: bool = False) -> Mapping[str, float]:
        """The least margin of each phase."""
        least = {}
        for each in self.moments:
            grasps = perturbed(each.grasps, draw)
            if held:
                grasps = _pressing(grasps, each.normal, draw)
            least[each.phase] = max(float(friction_drop(grasps).min()), LOWEST)
        return least


def perturbed(grasps: Grasps, draw: Perturbation) -> Grasps:
    """The grasps in the drawn world: mass, friction, places, width of the handle.

    A tool that is elsewhere than believed is touched elsewhere: the contacts move by the opposite
    of its error, along the tool's surface. A wider handle moves them outwards.
    """
    problem = grasps.problem
    fingers = np.array([name != PIVOT for name in grasps.names])
    x, y, yaw = draw.offset
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    # statics does not change when tool, contacts and forces turn about the vertical together:
    # the tool stays, the fingertips come out shifted and turned back
    shift = (problem.lever - np.array([x, y, 0.0])) @ turn - problem.lever
    off_surface = np.sum(shift * problem.normals, axis=2, keepdims=True) * problem.normals
    outwards = -0.5 * draw.handle_growth * problem.normals
    moved = problem.lever + np.where(fingers[:, None], shift - off_surface + outwards, 0.0)
    scale = np.where(fingers, draw.finger_friction_scale, draw.table_friction_scale)
    return grasps.changed(
        friction=grasps.friction * scale, lever=moved, wrench=draw.mass_scale * problem.wrench
    )


def alone(robot: Robot, name: str, share: float) -> Perturbation:
    """A draw with one perturbation, ``share`` (-1 to 1) of its usual half width; see SWEPT."""
    none = Perturbation.none(robot)
    half = SWEPT[name]
    if name.startswith("offset"):
        offset = np.zeros(3)
        offset[("offset_x", "offset_y", "offset_yaw").index(name)] = share * half
        return replace(none, offset=offset)
    if name == "handle_growth":
        return replace(none, handle_growth=share * half)
    return replace(none, **{name: 1.0 + share * half})


SWEPT = {
    "mass_scale": 0.2,
    "finger_friction_scale": 0.2,
    "table_friction_scale": 0.2,
    "offset_x": 1e-3,
    "offset_y": 1e-3,
    "offset_yaw": float(np.radians(1.0)),
    "handle_growth": 1e-3,
}
"""Half widths of the draws as scenes have them by default: [-], [m], [rad]."""


def _held(phase: Phase, body: PivotingTool) -> Held:
    moments = moments_of(phase, body)
    rows = np.searchsorted(phase.time - phase.time[0], moments.time_s)
    force = np.stack([phase.contacts[name].force[rows] for name in moments.grasps.names], axis=1)
    return Held(phase.name, moments.grasps, split_force(force, moments.grasps.problem.normals)[0])


def _pressing(grasps: Grasps, normal: Array, draw: Perturbation) -> Grasps:
    """The grasps with every finger's normal force as its sensor makes the controller hold it."""
    gain = np.array([draw.sensing.gain.get(name, np.nan) for name in grasps.names])
    fixed = np.where(np.isnan(gain), np.nan, np.maximum(normal, 0.0) / gain)
    # what a finger is made to press may be beyond the plan's bounds
    low, high = np.fmin(grasps.problem.normal_min, fixed), np.fmax(grasps.problem.normal_max, fixed)
    return grasps.changed(normal_fixed=fixed, normal_min=low, normal_max=high)
