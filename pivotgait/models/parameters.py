"""Names of a scene's parameters: the one vocabulary of sweeps, maps, mends and ``--set``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.models.robot_parts import write
from pivotgait.models.scene import Scene
from pivotgait.models.urdf.nodes import read_nodes

Value = float | str
Fields = dict[str, Any]
Place = tuple[str | int, ...]

MASS_SCALE = "tool.mass_scale"
"""The one parameter that is no field of the scene: factor of the tool's mass and inertia."""
EFFORT_SCALE = "robot.effort_scale"
"""Factor of the torque limits of all joints; a parameter of verdicts, not of sweeps and maps."""
PHASES = ("lift", "addition", "removal", "relocation")
LIFT_TARGET = {f"tool.{each}": f"lift.to.{each}" for each in ("pitch_deg", "roll_deg", "yaw_deg")}
HIDDEN = ("schema", "name", "description", "gaits", "tool")
"""Fields of a scene that no parameter sets."""


def places_of(parameter: str, fields: Fields, *, where: str) -> tuple[Place, ...]:
    """Where in a scene's fields a parameter sets its value.

    A parameter is a dotted path such as ``table.friction``, ``contacts.thumb_spine.along_m`` or
    ``gravity_m_s2.2``; ``*`` stands for every key (``contacts.*.friction``). ``lift``,
    ``addition``, ``removal`` and ``relocation`` stand for all phases of that kind in the gaits
    (``removal.duration_s``), and ``tool.pitch_deg``, ``tool.roll_deg`` and ``tool.yaw_deg`` for
    the lift's target.

    Args:
        parameter: the path.
        fields: of the scene, as its YAML file has them.
        where: the option or the study's field, in messages.

    Returns:
        Keys and indices from the root to each number or text; none for ``tool.mass_scale``.

    Raises:
        UnknownNameError: a key the scene does not have; lists those it has there.
        SceneError: a path that ends in no single value, a kind of phase that no gait has.
    """
    if parameter == MASS_SCALE:
        return ()
    keys = LIFT_TARGET.get(parameter, parameter).split(".")
    starts: list[tuple[Place, Any]] = [((), _roots(fields))]
    if keys[0] in PHASES:
        kind = keys.pop(0)
        starts = [
            (("gaits", gait, k), phase)
            for gait, phases in fields["gaits"].items()
            for k, phase in enumerate(phases)
            if phase["kind"] == kind
        ]
        if not starts:
            mend = "choose another gait or another parameter"
            raise SceneError(f"the gait has no {kind}", where=where, mend=mend)
    for depth, key in enumerate(keys):
        known: set[str] = set()
        starts = [step for start in starts for step in _enter(start, key, known)]
        if not starts:
            path = ".".join(keys[: depth + 1])
            raise UnknownNameError("parameter", path, [*sorted(known), *_more(depth)], where=where)
    return tuple(place for place, value in starts if _is_leaf(value, parameter, where))


def set_values(fields: Fields, places: tuple[Place, ...], value: Value) -> None:
    """Set a value at places of a scene's fields; whole numbers where one was."""
    for place in places:
        node: Any = fields
        for key in place[:-1]:
            node = node[key]
        counts = isinstance(node[place[-1]], int)
        whole = counts and isinstance(value, float) and value.is_integer()
        node[place[-1]] = int(value) if whole else value


def with_scaled_mass(scene: Scene, scale: Value) -> Scene:
    """The scene with a heavier or lighter tool of the same shape.

    Raises:
        SceneError: a factor that is no positive number.
    """
    if isinstance(scale, str) or not 0.0 < scale < float("inf"):
        what = f"must be a number > 0, got {scale}"
        raise SceneError(what, where=MASS_SCALE, mend="give 1.2 for a tool that is 20 % heavier")
    tool = scene.tool
    return replace(scene, tool=replace(tool, mass=scale * tool.mass, inertia=scale * tool.inertia))


def with_scaled_efforts(scene: Scene, scale: Value) -> Scene:
    """The scene with stronger or weaker joints, in the robot's URDF too.

    Raises:
        SceneError: a factor that is no positive number, or a scene without a robot.
    """
    if isinstance(scale, str) or not 0.0 < scale < float("inf"):
        what, mend = f"must be a number > 0, got {scale}", "give 1.2 for joints 20 % stronger"
        raise SceneError(what, where=EFFORT_SCALE, mend=mend)
    robot = scene.robot
    if robot is None:
        what, mend = "the scene has no robot", "choose another parameter"
        raise SceneError(what, where=EFFORT_SCALE, mend=mend)
    root = read_nodes(robot.urdf, where="robot.urdf")
    for joint in root.all("joint"):
        for limit in joint.all("limit"):
            limit.attributes["effort"] = repr(scale * float(limit.attributes["effort"]))
    stronger = replace(robot, urdf=write(root), effort_max=scale * robot.effort_max)
    return replace(scene, robot=stronger)


def _more(depth: int) -> tuple[str, ...]:
    return () if depth else (*PHASES, *LIFT_TARGET, MASS_SCALE)


def _roots(fields: Fields) -> Fields:
    return {key: value for key, value in fields.items() if key not in HIDDEN}


def _enter(start: tuple[Place, Any], key: str, known: set[str]) -> list[tuple[Place, Any]]:
    """The values one key below a place; ``known`` gathers the keys there are."""
    place, node = start
    if isinstance(node, Mapping):
        children: dict[str | int, Any] = dict(node)
    elif isinstance(node, list):
        children = dict(enumerate(node))
    else:
        children = {}
    known.update(map(str, children))
    return [((*place, each), child) for each, child in children.items() if key in ("*", str(each))]


def _is_leaf(value: Any, parameter: str, where: str) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        what = f"{parameter!r} is not a single number or name"
        keys = ", ".join(map(str, value)) if isinstance(value, Mapping) else "its parts"
        raise SceneError(what, where=where, mend=f"go on to one of: {keys}")
    return True
