"""Checks of a robot's fields against its URDF, before any index into Pinocchio's model."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.models.robot_config import FingerConfig, RobotConfig
from pivotgait.models.urdf import UrdfJoint, UrdfSummary

TIP_TOLERANCE = 1e-9
"""Between a tip's radius and centre in the scene and those of its sphere in the URDF [m]."""


def check_robot(summary: UrdfSummary, config: RobotConfig, *, where: str) -> None:
    """Check the scene's fields against the URDF.

    Raises:
        UnknownNameError: for a link or joint that the URDF does not have.
        SceneError: for fields that contradict one another or the URDF.
    """
    _check_names(summary, config, where)
    for name, finger in config.fingers.items():
        at = f"{where}.fingers.{name}"
        _check_chain(summary, config.palm, finger, at)
        _check_tip(summary, finger, at)
    _check_every_joint_has_a_place(summary, config, where)
    for joint, value in config.home.items():
        limit = summary.joints[joint]
        if not limit.lower <= value <= limit.upper:
            what = f"{value:g} is outside the limits [{limit.lower:g}, {limit.upper:g}]"
            raise SceneError(what, where=f"{where}.home.{joint}", mend="give a value within them")


def _check_names(summary: UrdfSummary, config: RobotConfig, where: str) -> None:
    # Pinocchio would answer with an index that ends the process later.
    links, moving = summary.links, _moving(summary.joints.values())
    _check_known("link", [config.palm], links, f"{where}.palm")
    for name, finger in config.fingers.items():
        at = f"{where}.fingers.{name}"
        _check_known("link", [finger.tip_frame], links, f"{at}.tip_frame")
        _check_known("moving joint", finger.joints, moving, f"{at}.joints")
        if np.linalg.norm(finger.pad) < 1e-6:
            raise SceneError("has no direction", where=f"{at}.pad", mend="give a vector")
    _check_known("moving joint", config.home, moving, f"{where}.home")
    for field, pairs, kind, known in (
        ("couplings", config.couplings, "moving joint", tuple(moving)),
        ("never_touch", config.never_touch, "link", tuple(links)),
    ):
        for place, pair in enumerate(pairs):
            at = f"{where}.{field}[{place}]"
            _check_known(kind, pair, known, at)
            if pair[0] == pair[1]:
                raise SceneError(f"pairs {pair[0]!r} with itself", where=at, mend="name two")


def _check_known(kind: str, names: Iterable[str], known: Iterable[str], at: str) -> None:
    known = tuple(known)
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known, where=at)


def _check_chain(summary: UrdfSummary, palm: str, finger: FingerConfig, at: str) -> None:
    """A finger's joints must be all those between palm and tip, from the palm outwards."""
    chain = _chain(summary, finger.tip_frame)
    links = [summary.root, *(joint.child for joint in chain)]
    if palm not in links:
        what = f"{finger.tip_frame!r} is not carried by the palm {palm!r}"
        raise SceneError(what, where=f"{at}.tip_frame", mend="name a link beyond the palm")
    between = _moving(chain[links.index(palm) :])
    if list(finger.joints) != between:
        listed = ", ".join(between) or "none"
        stray = [name for name in finger.joints if name not in between]
        missing = [name for name in between if name not in finger.joints]
        if stray:
            what = f"joint {stray[0]!r} does not lie between palm and {finger.tip_frame!r}"
        elif missing:
            what = f"joint {missing[0]!r} between palm and {finger.tip_frame!r} is missing"
        else:
            what = "joints are out of order or named twice"
        mend = f"from the palm outwards they are: {listed} (lock others under robot.fixed)"
        raise SceneError(what, where=f"{at}.joints", mend=mend)


def _check_tip(summary: UrdfSummary, finger: FingerConfig, at: str) -> None:
    """The certificate and the simulators take the tip for a sphere about its frame's origin."""
    spheres = [each for each in summary.links[finger.tip_frame].collisions if each.kind == "sphere"]
    centred = [each for each in spheres if np.linalg.norm(each.translation) <= TIP_TOLERANCE]
    if not centred:
        what = f"link {finger.tip_frame!r} has no collision sphere about its origin"
        raise SceneError(what, where=f"{at}.tip_frame", mend="add the fingertip's sphere to it")
    radii = [each.size[0] for each in centred]
    if all(abs(radius - finger.tip_radius_m) > TIP_TOLERANCE for radius in radii):
        what = f"{finger.tip_radius_m!r} m is not that of the sphere of {finger.tip_frame!r}"
        mend = f"the URDF says {radii[0]!r} m"
        raise SceneError(what, where=f"{at}.tip_radius_m", mend=mend)


def _check_every_joint_has_a_place(summary: UrdfSummary, config: RobotConfig, where: str) -> None:
    """A joint of no finger must move the palm: q_h holds arm and wrist, nothing else."""
    arm = _moving(_chain(summary, config.palm))
    of_finger: dict[str, str] = {}
    for name, finger in config.fingers.items():
        for joint in finger.joints:
            if joint in of_finger:
                what = f"{of_finger[joint]!r} and {name!r} share joint {joint!r}"
                raise SceneError(what, where=f"{where}.fingers", mend="part them")
            of_finger[joint] = name
    for joint in _moving(summary.joints.values()):
        if joint not in arm and joint not in of_finger:
            what = f"joint {joint!r} moves neither the palm nor a finger's tip"
            mend = f"lock it under robot.fixed, such as {{{joint}: 0}}"
            raise SceneError(what, where=where, mend=mend)


def _chain(summary: UrdfSummary, link: str) -> list[UrdfJoint]:
    """Joints from the root to ``link``."""
    above = {joint.child: joint for joint in summary.joints.values()}
    chain: list[UrdfJoint] = []
    while link in above:
        chain.insert(0, above[link])
        link = above[link].parent
    return chain


def _moving(joints: Iterable[UrdfJoint]) -> list[str]:
    return [joint.name for joint in joints if joint.kind != "fixed"]
