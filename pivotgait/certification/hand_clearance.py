"""How far the robot stays from itself, the tool and the table, wanted contacts apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.certification.certificate import Finding, smallest
from pivotgait.certification.poses import Poses, with_middles, woven
from pivotgait.certification.surroundings import Surroundings
from pivotgait.certification.tips import TipMotion, holding
from pivotgait.frozen import Array
from pivotgait.plans import Phase, RobotMotion

_NEAR_CONTACT = 5e-3
"""A moving tip [m] this near to a contact that it leaves or reaches may be nearer to the tool than
the clearance, else no tip could ever land."""


@dataclass(frozen=True, eq=False)
class _Distances:
    """Smallest distances [m] at M poses: whole robot but tips to tool, and each tip to the tool."""

    hand: Array
    links: list[str]
    tips: Mapping[str, Array]


def check_hand_clearance(
    phase: Phase,
    motion: RobotMotion,
    tips: Mapping[str, TipMotion],
    surroundings: Surroundings,
    clearance: float,
) -> Iterator[Finding]:
    """Smallest distance outside the wanted contacts, and of fingertips at their contacts [m].

    At every sample and in the middle between two. A holding finger's tip sphere may touch the
    tool. So may that of the finger which a relocation moves, while its centre is within 5 mm of
    where it starts or ends, if it touches there. All other distances count in full.

    Args:
        phase: one of the plan's phases.
        motion: the robot's in that phase.
        tips: motion of every fingertip in it.
        surroundings: robot, tool and table.
        clearance: below which a tip at the end of a relocation counts as touching [m].
    """
    poses = with_middles(phase, motion)
    found = _measure(poses, surroundings)
    worst = int(np.argmin(found.hand))  # the first NaN, if there is one
    candidates = [_finding(found.hand, poses, phase, found.links[worst])]
    for finger, distance in found.tips.items():
        touching = _touching(phase, finger, tips[finger], distance, clearance)
        if np.any(touching[::2]):
            # Samples only: between them the interpolation, not the plan, decides on micrometres.
            near = np.where(touching, distance, np.inf)[::2]
            yield smallest("tip_penetration_m", near, phase, finger)
        if not np.all(touching):
            free = np.where(touching, np.inf, distance)
            part = f"{surroundings.tip_links[finger]} - tool"
            candidates.append(_finding(free, poses, phase, part, finger))
    yield min(candidates, key=lambda each: -np.inf if np.isnan(each.value) else each.value)


def _measure(poses: Poses, surroundings: Surroundings) -> _Distances:
    count = len(poses.time)
    hand, links = np.empty(count), []
    tips = {finger: np.empty(count) for finger in surroundings.tip_links}
    for k, pose in enumerate(zip(poses.q, poses.position, poses.orientation, strict=True)):
        hand[k], between = surroundings.measure(*pose)
        links.append(between)
        for finger, distance in tips.items():
            distance[k] = surroundings.tip_to_tool(finger)
    return _Distances(hand, links, tips)


def _touching(
    phase: Phase, finger: str, tip: TipMotion, distance: Array, clearance: float
) -> NDArray[np.bool_]:
    """(M,) whether a tip is at a contact: it holds, or has just left one or is about to land."""
    if finger in holding(phase):
        return np.ones(len(distance), dtype=bool)
    touching = np.zeros(len(distance), dtype=bool)
    if phase.kind != "relocation" or finger != phase.finger:
        return touching
    from_tool = tip.position - phase.tool.position
    on_tool = np.einsum("nji,nj->ni", phase.tool.rotation.as_matrix(), from_tool)
    centre = woven(on_tool, 0.5 * (on_tool[:-1] + on_tool[1:]))
    for end in (0, -1):
        if distance[end] < clearance:
            touching |= np.linalg.norm(centre - centre[end], axis=1) <= _NEAR_CONTACT
    return touching


def _finding(distance: Array, poses: Poses, phase: Phase, part: str, contact: str = "") -> Finding:
    k = int(np.argmin(distance))
    time = float(poses.time[k])
    return Finding("hand_clearance_m", float(distance[k]), phase.name, contact, time, part)
