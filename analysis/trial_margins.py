"""Margins that a plan keeps in a world that is not as planned: what a trial's draw leaves of it.

Each is the least over the moments of every phase (middle, weakest, end), for contact forces that
hold the tool on its planned motion with the drawn mass, friction, places and width of the handle.
The first two are the share by which all friction could drop, 1 for a grasp that needs no friction,
0 at its edge, negative beyond:

* **free**: forces may be allocated anew, as if everything were known;
* **held**: each finger presses with the normal force that the controller believes in, the
  planned one over the drawn gain of its sensor; tangential forces and the table make up the rest.

The third is a force:

* **sensed**: the controller wants each finger's reading, wrong in size and direction, to be the
  planned normal force. Where no forces do that, readings must miss it by some newtons, for which
  impedance control lets the fingertips give way; the margin is the least such miss, negative.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts.cone import split_force
from pivotgait.dynamics import PivotingTool
from pivotgait.feasibility import Grasps, friction_drop, static_verdicts
from pivotgait.feasibility.edges import Index, last_feasible
from pivotgait.feasibility.moments import moments_of
from pivotgait.forces import LinearRows
from pivotgait.frozen import Array
from pivotgait.models import Robot, Scene
from pivotgait.phases.grasp import Setting
from pivotgait.plans import PIVOT, GaitPlan, Phase
from pivotgait.validation.perturbation import Perturbation

LOWEST = -30.0
"""Stands for minus infinity: no amount of friction helps."""
MISS_MAX_N, MISS_EXACT_N = 60.0, 1e-3
"""Largest miss of the readings that is sought, and the one that counts as none."""
FREE_N = 1e-6
"""A finger that presses less does not touch."""


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

    def sensed_margin(self, draw: Perturbation) -> float:
        """The least margin of the readings over all phases [N], see the module's text."""
        return min(float(_miss(each, draw).min()) for each in self.moments)


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


def _miss(held: Held, draw: Perturbation) -> Array:
    """(B,) minus the least largest miss of the fingers' readings [N], not below -60.

    A reading's normal part is gain n . (turn f): linear in the force, so that a largest miss is a
    pair of rows for each finger, and the least of them an edge of feasibility. The plan's bounds of
    normal forces bind the planner alone; what really happens needs but to press.
    """
    grasps = perturbed(held.grasps, draw)
    problem = grasps.problem
    touching = np.array([name == PIVOT for name in grasps.names]) | (held.normal > FREE_N)
    grasps = grasps.changed(
        normal_min=np.zeros_like(problem.normal_min),
        normal_max=np.full_like(problem.normal_max, np.inf),
        normal_fixed=np.where(touching, np.nan, 0.0),
    )
    fingers = [place for place, name in enumerate(grasps.names) if name != PIVOT]
    matrix = np.zeros((grasps.count, len(fingers), len(grasps.names), 3))
    for row, place in enumerate(fingers):
        name = grasps.names[place]
        reading = draw.sensing.gain[name] * draw.sensing.turn[name]
        matrix[:, row, place] = problem.normals[:, place] @ reading
    # a finger that does not press yet, or no longer, bears nothing and reads nothing
    wanted = np.where(touching, held.normal, 0.0)[:, fingers]
    matrix = matrix.reshape(grasps.count, len(fingers), -1)

    def holds(line: Index, miss: Array) -> NDArray[np.bool_]:
        room = MISS_EXACT_N - miss[:, None]
        rows = LinearRows(matrix[line], wanted[line] - room, wanted[line] + room)
        return static_verdicts(grasps.take(line).changed(rows=rows)).feasible

    found = last_feasible(np.full(grasps.count, -MISS_MAX_N), np.zeros(grasps.count), holds)
    return np.nan_to_num(found, nan=-MISS_MAX_N)


def _pressing(grasps: Grasps, normal: Array, draw: Perturbation) -> Grasps:
    """The grasps with every finger's normal force as its sensor makes the controller hold it."""
    gain = np.array([draw.sensing.gain.get(name, np.nan) for name in grasps.names])
    fixed = np.where(np.isnan(gain), np.nan, np.maximum(normal, 0.0) / gain)
    # what a finger is made to press may be beyond the plan's bounds
    low, high = np.fmin(grasps.problem.normal_min, fixed), np.fmax(grasps.problem.normal_max, fixed)
    return grasps.changed(normal_fixed=fixed, normal_min=low, normal_max=high)
