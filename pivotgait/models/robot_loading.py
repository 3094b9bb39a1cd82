"""The robot of a scene: checked by its text, then read by Pinocchio."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.models.robot import Finger, Robot
from pivotgait.models.robot_config import FingerConfig, RobotConfig
from pivotgait.models.urdf import check_urdf


def build_robot(urdf: str, config: RobotConfig, *, where: str) -> Robot:
    """The robot of a URDF's text, with the fingers that the scene names.

    Args:
        urdf: the whole text, primitives only; its root is the world frame.
        config: the scene's fields.
        where: name of the scene's field in messages.

    Raises:
        UrdfError: for text that must not reach the native parsers.
        UnknownNameError: for a link or joint that the URDF does not have.
        SceneError: for fields that contradict one another or the URDF.
    """
    summary = check_urdf(urdf, where=f"{where}.urdf")
    for name in (config.palm, *(finger.tip_frame for finger in config.fingers.values())):
        if name not in summary.links:
            # Pinocchio would answer with an index that ends the process later.
            raise UnknownNameError("link", name, summary.links, where=where)
    model = pin.buildModelFromXML(urdf)
    collision = pin.buildGeomFromUrdfString(model, urdf, pin.GeometryType.COLLISION)
    add_self_pairs(model, collision, config.never_touch)
    column = {name: place for place, name in enumerate(model.names[1:])}
    fingers = {
        name: _finger(model, column, name, each, f"{where}.fingers.{name}")
        for name, each in config.fingers.items()
    }
    used = [each for finger in fingers.values() for each in finger.columns]
    if len(set(used)) != len(used):
        raise SceneError("two fingers share a joint", where=f"{where}.fingers", mend="part them")
    lower, upper = np.array(model.lowerPositionLimit), np.array(model.upperPositionLimit)
    velocity = np.array(model.upperVelocityLimit)
    return Robot(
        name=summary.name,
        urdf=urdf,
        model=model,
        collision=collision,
        palm_frame=config.palm,
        palm_frame_id=model.getFrameId(config.palm, pin.FrameType.BODY),
        palm_columns=tuple(k for k in range(model.nv) if k not in used),
        fingers=MappingProxyType(fingers),
        lower=lower,
        upper=upper,
        velocity_max=velocity,
        acceleration_max=velocity / config.ramp_time_s,
        effort_max=np.array(model.upperEffortLimit),
        couplings=tuple(
            (_column(column, i, where), _column(column, k, where)) for i, k in config.couplings
        ),
        home=_home(config, column, lower, upper, where),
    )


def add_self_pairs(model: Any, collision: Any, ignored: tuple[tuple[str, str], ...]) -> None:
    """Pair every two shapes whose links may meet: not the same, not neighbours, not ignored."""
    collision.addAllCollisionPairs()
    skip = {frozenset(pair) for pair in ignored}
    for pair in list(collision.collisionPairs):
        one, other = (collision.geometryObjects[i] for i in (pair.first, pair.second))
        a, b = one.parentJoint, other.parentJoint
        links = frozenset(model.frames[each.parentFrame].name for each in (one, other))
        if a == b or model.parents[a] == b or model.parents[b] == a or links in skip:
            collision.removeCollisionPair(pair)


def _finger(
    model: Any, column: dict[str, int], name: str, config: FingerConfig, where: str
) -> Finger:
    pad = np.array(config.pad)
    if not np.linalg.norm(pad) > 0.0:
        raise SceneError("pad is zero", where=where, mend="give a direction")
    return Finger(
        name=name,
        tip_frame=config.tip_frame,
        tip_frame_id=model.getFrameId(config.tip_frame, pin.FrameType.BODY),
        tip_radius=config.tip_radius_m,
        pad=pad / np.linalg.norm(pad),
        pad_cone=float(np.radians(config.pad_cone_deg)),
        joints=config.joints,
        columns=tuple(_column(column, joint, where) for joint in config.joints),
    )


def _column(column: dict[str, int], joint: str, where: str) -> int:
    if joint not in column:
        raise UnknownNameError("joint", joint, column, where=where)
    return column[joint]


def _home(
    config: RobotConfig, column: dict[str, int], lower: Array, upper: Array, where: str
) -> Array:
    home = 0.5 * (lower + upper)
    for joint, value in config.home.items():
        home[_column(column, joint, f"{where}.home")] = value
    return np.clip(home, lower, upper)
