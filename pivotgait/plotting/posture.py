"""Where the links of an arm-hand are, and to which part of it each belongs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import PlanFileError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.models.urdf import UrdfJoint, UrdfSummary, check_urdf
from pivotgait.plans.plan import PlannedRobot

ARM, HAND = "arm", "hand"
"""Parts of an arm-hand besides its fingers: all above the palm; the palm and folded fingers."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A planned arm-hand, read from its URDF.

    Attributes:
        urdf: what its URDF says.
        joint_names: in the order of the coordinates q.
        palm: name of the link on which the chains of all fingers meet.
        parts: link's name -> :data:`ARM`, :data:`HAND` or the name of a finger.
        tips: names of the fingertips' links.
        tip_radius: finger's name -> radius of its tip's sphere [m].
    """

    urdf: UrdfSummary
    joint_names: tuple[str, ...]
    palm: str
    parts: Mapping[str, str]
    tips: tuple[str, ...]
    tip_radius: Mapping[str, float]

    def joints_of(self, part: str) -> tuple[str, ...]:
        """Names of the moving joints of a finger, or of the palm: all that belong to no finger."""
        fingers = set(self.tip_radius)
        part_of = {name: self.parts[self.urdf.joints[name].child] for name in self.joint_names}
        if part in fingers:
            return tuple(name for name in self.joint_names if part_of[name] == part)
        return tuple(name for name in self.joint_names if part_of[name] not in fingers)

    def poses(self, q: Array) -> Mapping[str, Array]:
        """Poses (N, 4, 4) of every link, world <- link [m], at joint positions q (N, n)."""
        column = {name: place for place, name in enumerate(self.joint_names)}
        count = len(q)
        found = {self.urdf.root: np.broadcast_to(np.eye(4), (count, 4, 4))}
        for joint in _parents_first(self.urdf):
            moved = q[:, column[joint.name]] if joint.kind != "fixed" else np.zeros(count)
            found[joint.child] = found[joint.parent] @ _across(joint, moved)
        return MappingProxyType(found)


def skeleton(robot: PlannedRobot) -> Skeleton:
    """Read a planned arm-hand.

    Raises:
        UrdfError: if its URDF is broken.
        UnknownNameError: for a fingertip that the URDF does not have.
        PlanFileError: if its joints are not those of the URDF.
    """
    where = "the plan's robot"
    urdf = check_urdf(robot.urdf, where=where)
    moving = {joint.name for joint in urdf.joints.values() if joint.kind != "fixed"}
    if moving != set(robot.joint_names):
        odd = ", ".join(sorted(moving ^ set(robot.joint_names))[:4])
        raise PlanFileError(f"joints do not match the URDF: {odd}", where=where, mend="plan anew")
    for finger in robot.fingers.values():
        if finger.tip_frame not in urdf.links:
            raise UnknownNameError("link", finger.tip_frame, urdf.links, where=where)
    chains = {name: _chain(urdf, each.tip_frame) for name, each in robot.fingers.items()}
    palm = _meeting_link(chains)
    return Skeleton(
        urdf,
        robot.joint_names,
        palm,
        MappingProxyType(_parts(urdf, chains, palm)),
        tuple(each.tip_frame for each in robot.fingers.values()),
        MappingProxyType({name: each.tip_radius for name, each in robot.fingers.items()}),
    )


def _chain(urdf: UrdfSummary, link: str) -> list[str]:
    """Names of the links from the root down to ``link``."""
    parent = {joint.child: joint.parent for joint in urdf.joints.values()}
    chain = [link]
    while chain[0] in parent:
        chain.insert(0, parent[chain[0]])
    return chain


def _meeting_link(chains: Mapping[str, list[str]]) -> str:
    """The last link that all chains share; with a single finger, the one that carries its tip."""
    shared = [level[0] for level in zip(*chains.values(), strict=False) if len(set(level)) == 1]
    shortest = min(len(chain) for chain in chains.values())
    palm: str = shared[min(len(shared), shortest - 1) - 1]
    return palm


def _parts(urdf: UrdfSummary, chains: Mapping[str, list[str]], palm: str) -> dict[str, str]:
    parts = {name: HAND if palm in _chain(urdf, name) else ARM for name in urdf.links}
    for finger, chain in chains.items():
        parts |= dict.fromkeys(chain[chain.index(palm) + 1 :], finger)
    return parts


def _parents_first(urdf: UrdfSummary) -> list[UrdfJoint]:
    return sorted(urdf.joints.values(), key=lambda joint: len(_chain(urdf, joint.child)))


def _across(joint: UrdfJoint, moved: Array) -> Array:
    """(N, 4, 4) pose of a joint's child in its parent at coordinates (N,)."""
    pose = np.tile(np.eye(4), (len(moved), 1, 1))
    along = moved[:, None] * joint.axis
    if joint.kind == "prismatic":
        pose[:, :3, :3] = joint.rotation
        pose[:, :3, 3] = joint.translation + along @ joint.rotation.T
    else:
        pose[:, :3, :3] = joint.rotation @ Rotation.from_rotvec(along).as_matrix()
        pose[:, :3, 3] = joint.translation
    return pose
