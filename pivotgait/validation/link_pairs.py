"""Which contacts of the robot with itself and the table are no contacts at all."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

from pivotgait.models.urdf import UrdfSummary, check_urdf


@dataclass(frozen=True)
class QuietPairs:
    """What the simulator must not report.

    Attributes:
        among: pairs of the robot's links that are one body, neighbours, or never touch.
        fixed: links that stand fixed in the world, on the table or beside it.
    """

    among: tuple[tuple[str, str], ...]
    fixed: tuple[str, ...]


def quiet_pairs(urdf: str, never_touch: Iterable[tuple[str, str]]) -> QuietPairs:
    """The pairs of a robot's URDF text.

    Links fixed to one another move as one body; two bodies that a joint connects are neighbours.
    """
    summary = check_urdf(urdf, where="robot of the plan")
    body = _bodies(summary)
    moving = [joint for joint in summary.joints.values() if joint.kind != "fixed"]
    near = {frozenset((body[joint.parent], body[joint.child])) for joint in moving}
    skip = {frozenset(pair) for pair in never_touch}
    among = tuple(
        (one, other)
        for one, other in combinations(summary.links, 2)
        if body[one] == body[other]
        or frozenset((body[one], body[other])) in near
        or frozenset((one, other)) in skip
    )
    return QuietPairs(among, tuple(link for link in body if body[link] == summary.root))


def _bodies(summary: UrdfSummary) -> dict[str, str]:
    """For each link the link nearest to the root that it is fixed to."""
    joint_to = {joint.child: joint for joint in summary.joints.values()}

    def body(link: str) -> str:
        joint = joint_to.get(link)
        return link if joint is None or joint.kind != "fixed" else body(joint.parent)

    return {link: body(link) for link in summary.links}
