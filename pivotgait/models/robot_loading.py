"""The robot of a scene: checked by its text, then read by Pinocchio."""

from __future__ import annotations

from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import SceneError
from pivotgait.frozen import Array
from pivotgait.models.robot import Finger, Robot
from pivotgait.models.robot_checks import check_robot
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
    check_robot(summary, config, where=where)
    model = pin.buildModelFromXML(urdf)
    collision = pin.buildGeomFromUrdfString(model, urdf, pin.GeometryType.COLLISION)
    add_self_pairs(model, collision, config.never_touch)
    column = {name: place for place, name in enumerate(model.names[1:])}
    fingers = {name: _finger(model, column, name, each) for name, each in config.fingers.items()}
    used = {each for finger in fingers.values() for each in finger.columns}
    lower, upper = np.array(model.lowerPositionLimit), np.array(model.upperPositionLimit)
    velocity = np.array(model.upperVelocityLimit)
    couplings = tuple((column[i], column[k]) for i, k in config.couplings)
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
        couplings=couplings,
        never_touch=config.never_touch,
        home=_home(config, column, lower, upper, couplings, where),
    )


def add_self_pairs(model: Any, collision: Any, ignored: tuple[tuple[str, str], ...]) -> None:
    """Pair every two shapes whose links may meet: not the same, not neighbours, not ignored.

    Links fixed to one another move as one body: they neither meet nor differ as neighbours.
    """
    skip = {frozenset(pair) for pair in ignored}
    bodies = [shape.parentJoint for shape in collision.geometryObjects]
    links = [model.frames[shape.parentFrame].name for shape in collision.geometryObjects]
    for i, k in combinations(range(collision.ngeoms), 2):
        a, b = bodies[i], bodies[k]
        neighbours = a == b or model.parents[a] == b or model.parents[b] == a
        if not neighbours and frozenset((links[i], links[k])) not in skip:
            collision.addCollisionPair(pin.CollisionPair(i, k))


def _finger(model: Any, column: dict[str, int], name: str, config: FingerConfig) -> Finger:
    pad = np.array(config.pad)
    return Finger(
        name=name,
        tip_frame=config.tip_frame,
        tip_frame_id=model.getFrameId(config.tip_frame, pin.FrameType.BODY),
        tip_radius=config.tip_radius_m,
        pad=pad / np.linalg.norm(pad),
        pad_cone=float(np.radians(config.pad_cone_deg)),
        joints=config.joints,
        columns=tuple(column[joint] for joint in config.joints),
    )


def _home(
    config: RobotConfig,
    column: dict[str, int],
    lower: Array,
    upper: Array,
    couplings: tuple[tuple[int, int], ...],
    where: str,
) -> Array:
    """The given positions, the middle of the range elsewhere (nv,)."""
    home = 0.5 * (lower + upper)
    for joint, value in config.home.items():
        home[column[joint]] = value
    names = list(column)
    for i, k in couplings:
        if home[i] > home[k]:
            what = (
                f"{names[i]} = {home[i]:g} exceeds {names[k]} = {home[k]:g}, to which it is coupled"
            )
            raise SceneError(what, where=f"{where}.home", mend=f"lower {names[i]}")
    return home
