"""Arm and hand as one robot, joints locked, the base placed: edits of a URDF's elements."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.models.robot_config import BaseConfig, MountConfig
from pivotgait.models.robot_parts import element, massless, origin
from pivotgait.models.urdf.elements import read_joint, read_origin
from pivotgait.models.urdf.nodes import Node

PREFIX = "hand_"
"""Put before a name of the hand that the arm has already; other names stay as they are.

Should that name be taken as well, underscores follow until it is free.
"""


def join(arm: Node, hand: Node, mount: MountConfig, *, where: str) -> Node:
    """One robot of an arm and a hand whose root link is fixed to a link of the arm.

    The arm's names stay. A link, joint or shape of the hand keeps its name unless the arm has
    that name; then it is called ``hand_`` and its name.

    Raises:
        UnknownNameError: for a frame that is no link of the arm.
    """
    links = _names(arm, "link")
    if mount.frame not in links:
        raise UnknownNameError("link", mount.frame, links, where=f"{where}.frame")
    _rename(hand, arm)
    joined = element(
        "robot",
        *arm.children,
        *hand.children,
        name=f"{arm.attributes['name']}_{hand.attributes['name']}",
        version="1.1",
    )
    rotation = Rotation.from_euler("xyz", mount.rpy_deg, degrees=True).as_matrix()
    pose = origin(rotation, np.array(mount.position_m))
    joined.children.append(_fixed_joint(joined, "mount", mount.frame, root_of(hand), pose))
    return joined


def lock(robot: Node, fixed: Mapping[str, float], *, where: str) -> None:
    """Turn joints into fixed ones at the given positions [rad] or [m], in place.

    Raises:
        UnknownNameError: for a name that is no moving joint.
        SceneError: for a position outside the joint's limits.
    """
    moving = {
        node.attributes["name"]: node
        for node in robot.all("joint")
        if node.attributes["type"] != "fixed"
    }
    for name, position in fixed.items():
        if name not in moving:
            raise UnknownNameError("moving joint", name, moving, where=where)
        node = moving[name]
        joint = read_joint(node, where)
        if not joint.lower <= position <= joint.upper:
            what = f"{position:g} is outside the limits [{joint.lower:g}, {joint.upper:g}]"
            raise SceneError(what, where=f"{where}.{name}", mend="give a value within them")
        rotation, translation = read_origin(node, where)
        if joint.kind == "revolute":
            pose = origin(rotation @ pin.exp3(joint.axis * position), translation)
        else:
            pose = origin(rotation, translation + rotation @ joint.axis * position)
        ends = [child for child in node.children if child.tag in ("parent", "child")]
        node.attributes["type"], node.children = "fixed", [*ends, pose]


def place(robot: Node, base: BaseConfig) -> None:
    """Hang the root link on a new root at the world's origin, in place; not for the identity."""
    if base == BaseConfig():
        return
    root = root_of(robot)
    world = _unused("world", {*_names(robot, "link"), *_names(robot, "joint")})
    turn = Rotation.from_euler("z", base.yaw_deg, degrees=True).as_matrix()
    robot.children.insert(0, element("link", name=world))
    pose = origin(turn, np.array(base.position_m))
    robot.children.append(_fixed_joint(robot, "base_placement", world, root, pose))


def weigh_frames(robot: Node) -> None:
    """Write down that links without mass weigh nothing, in place; the root stays as it is."""
    root = root_of(robot)
    for link in robot.all("link"):
        if link.attributes["name"] != root and not any(link.all("inertial")):
            link.children.insert(0, massless())


def root_of(robot: Node) -> str:
    """Name of the one link that is no joint's child."""
    children = {
        node.attributes["link"] for joint in robot.all("joint") for node in joint.all("child")
    }
    return next(name for name in _names(robot, "link") if name not in children)


def _fixed_joint(robot: Node, name: str, parent: str, child: str, pose: Node) -> Node:
    name = _unused(name, {*_names(robot, "link"), *_names(robot, "joint")})
    ends = element("parent", link=parent), element("child", link=child)
    return element("joint", *ends, pose, name=name, type="fixed")


def _rename(hand: Node, arm: Node) -> None:
    """Give the hand's links, joints and shapes names that the arm does not have, in place."""
    # Links and joints share one name space: Pinocchio's frames hold both.
    frames = _new_names(hand, arm, ("link", "joint"))
    for tag in ("link", "joint"):
        for node in hand.all(tag):
            node.attributes["name"] = frames[node.attributes["name"]]
    for joint in hand.all("joint"):
        for end in (*joint.all("parent"), *joint.all("child")):
            end.attributes["link"] = frames[end.attributes["link"]]
    shapes = _new_names(hand, arm, ("collision",))
    for link in hand.all("link"):
        for shape in link.all("collision"):
            shape.attributes["name"] = shapes[shape.attributes["name"]]


def _new_names(hand: Node, arm: Node, tags: tuple[str, ...]) -> dict[str, str]:
    own, taken = ({name for tag in tags for name in _names(each, tag)} for each in (hand, arm))
    return {
        name: _unused(PREFIX + name, own | taken) if name in taken else name for name in sorted(own)
    }


def _unused(name: str, taken: set[str]) -> str:
    while name in taken:
        name = f"{name}_"
    return name


def _names(robot: Node, tag: str) -> list[str]:
    if tag == "collision":
        nodes = [shape for link in robot.all("link") for shape in link.all("collision")]
    else:
        nodes = list(robot.all(tag))
    return [node.attributes["name"] for node in nodes]
