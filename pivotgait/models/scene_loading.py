"""Scenes from a built-in name, a file or a text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import ValidationError

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.models.builtin_files import BuiltinFiles
from pivotgait.models.paths import is_file
from pivotgait.models.rest import attitude, rest_pitch
from pivotgait.models.robot import Robot
from pivotgait.models.robot_loading import build_robot
from pivotgait.models.robot_urdf import robot_urdf
from pivotgait.models.scene import HandleContact, Scene, Table
from pivotgait.models.scene_checks import check_config, check_lifts, check_postures
from pivotgait.models.scene_config import ContactConfig, SceneConfig, ToolConfig
from pivotgait.models.scene_errors import as_scene_error
from pivotgait.models.scene_yaml import MAX_BYTES, read_yaml
from pivotgait.models.tool import Tool, load_tool
from pivotgait.models.urdf_files import find_urdf

_BUILTIN = BuiltinFiles("scene", "pivotgait.models", "scenes")


def builtin_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package, sorted."""
    return _BUILTIN.names()


def export_scene(name: str) -> str:
    """YAML text of a built-in scene.

    Raises:
        UnknownNameError: listing the built-in scenes.
    """
    return _BUILTIN.text(name)


def scene_folder(scene: str) -> Path | None:
    """In which a scene's relative URDF paths start; None for a built-in scene.

    Args:
        scene: as :func:`load_scene` takes it.
    """
    return None if scene in builtin_scenes() else Path(scene).parent


def scene_schema() -> dict[str, Any]:
    """JSON schema of the scene file, for editors."""
    return SceneConfig.model_json_schema(by_alias=True)


def load_scene(scene: str | Path) -> Scene:
    """Load a scene.

    Args:
        scene: a built-in name, or the path of a YAML file.

    Raises:
        SceneError: naming the field and the way to mend it.
        UrdfError: for the tool's URDF.
        UnknownNameError: for a scene, tool, shape or contact that does not exist.
    """
    if isinstance(scene, str) and scene in builtin_scenes():
        return parse_scene(export_scene(scene), where=f"{scene}.yaml")
    path = Path(scene)
    if path.name == str(scene) and path.suffix == "" and not is_file(path):
        raise UnknownNameError("scene", str(scene), builtin_scenes())
    return parse_scene(_read(path), where=path.name, folder=path.parent)


def parse_scene(text: str, *, where: str = "scene", folder: Path | None = None) -> Scene:
    """Load a scene from its YAML text.

    Args:
        text: the whole YAML text.
        where: its name in messages.
        folder: in which a relative URDF path starts; without it only built-in tools are found.

    Raises:
        SceneError, UrdfError, UnknownNameError: as :func:`load_scene`.
    """
    config = _validate(_as_json(read_yaml(text, where=where), where), where)
    check_config(config, where)
    tool = _load_tool(config.tool, folder, where)
    robot = _load_robot(config, folder, where)
    contacts = _contacts(config, tool, where)
    return _assemble(config, text, tool, robot, contacts, _rest(config, tool, where), where)


def revise_scene(
    scene: Scene, fields: dict[str, Any], *, where: str = "scene", folder: Path | None = None
) -> Scene:
    """A scene with other values of its fields; keeps what they do not touch, which takes time.

    Args:
        scene: to start from.
        fields: all of the new scene's, named as in the YAML file.
        where: its name in messages.
        folder: in which a relative URDF path starts, should the tool or the robot change.

    Raises:
        SceneError, UrdfError, UnknownNameError: as :func:`load_scene`.
    """
    text = _as_json(fields, where)
    config, old = _validate(text, where), scene.config
    check_config(config, where)
    tool, robot, known = scene.tool, scene.robot, scene.contacts
    if config.tool != old.tool:
        tool, known = _load_tool(config.tool, folder, where), {}
    if (config.robot, config.gravity_m_s2) != (old.robot, old.gravity_m_s2):
        robot = _load_robot(config, folder, where)
    places = {name: _place(contact) for name, contact in old.contacts.items()}
    kept = {
        name: (known[name].point, known[name].normal)
        for name, contact in config.contacts.items()
        if name in known and places[name] == _place(contact)
    }
    contacts = _contacts(config, tool, where, kept)
    same = (config.tool, config.rest) == (old.tool, old.rest)
    rest = (scene.rest_pitch, scene.rest_orientation) if same else _rest(config, tool, where)
    return _assemble(config, text, tool, robot, contacts, rest, where)


def _rest(config: SceneConfig, tool: Tool, where: str) -> tuple[float, Array]:
    """Pitch [rad] and orientation (4,), xyzw, in which the tool rests on the table."""
    yaw, roll = np.radians([config.rest.yaw_deg, config.rest.roll_deg])
    pitch = rest_pitch(tool, roll, where=f"{where}: rest")
    return pitch, attitude(yaw, pitch, roll).as_quat(canonical=True)


def _place(contact: ContactConfig) -> tuple[float, float]:
    return contact.along_m, contact.around_deg


def _assemble(
    config: SceneConfig,
    text: str,
    tool: Tool,
    robot: Robot | None,
    contacts: Mapping[str, HandleContact],
    rest: tuple[float, Array],
    where: str,
) -> Scene:
    table = config.table
    scene = Scene(
        name=config.name,
        description=config.description,
        config=config,
        yaml=text,
        tool=tool,
        table=Table(
            table.height_m,
            np.array(table.centre_m),
            np.array(table.half_size_m),
            table.friction,
            table.normal_force_N.min,
            table.normal_force_N.max,
        ),
        robot=robot,
        gravity=np.array(config.gravity_m_s2),
        clearance=config.clearance_m,
        pivot=np.array([*config.rest.pivot_m, table.height_m + tool.tip_radius]),
        rest_pitch=rest[0],
        rest_orientation=rest[1],
        contacts=MappingProxyType(dict(contacts)),
        gaits=MappingProxyType(dict(config.gaits)),
    )
    check_lifts(scene, where)
    check_postures(scene, where)
    return scene


def _as_json(data: dict[str, Any], where: str) -> str:
    try:
        return json.dumps(data, default=str)
    except (TypeError, ValueError, RecursionError) as error:
        mend = "use plain text as keys and no alias to itself"
        raise SceneError(f"cannot be used: {error}", where=where, mend=mend) from error


def _validate(text: str, where: str) -> SceneConfig:
    # From JSON, so that pydantic's strict mode takes lists for tuples but no "1.5" for 1.5.
    try:
        return SceneConfig.model_validate_json(text)
    except ValidationError as error:
        raise as_scene_error(error, SceneConfig, where) from error


def _contacts(
    config: SceneConfig,
    tool: Tool,
    where: str,
    kept: Mapping[str, tuple[Array, Array]] | None = None,
) -> dict[str, HandleContact]:
    """Contacts by name; those in ``kept`` are known to be at a point with a normal."""
    contacts, known = {}, kept or {}
    for name, given in config.contacts.items():
        at = f"{where}: contacts.{name}"
        if name in known:
            point, normal = known[name]
        else:
            place = tool.place(given.along_m, np.radians(given.around_deg), where=at)
            point, normal = place.point, place.normal
        bounds = given.normal_force_N
        contacts[name] = HandleContact(
            name,
            given.finger,
            point,
            normal,
            given.friction,
            bounds.min,
            bounds.max,
            given.torsion_m,
        )
    return contacts


def _load_tool(config: ToolConfig, folder: Path | None, where: str) -> Tool:
    handle = config.handle
    file = find_urdf(config.urdf, folder, kind="tool", at=f"{where}: tool.urdf")
    return load_tool(
        file.path,
        tip=config.tip,
        handle=handle.shapes,
        origin=np.array(handle.origin_m),
        axis=np.array(handle.axis),
        zero=np.array(handle.zero),
        roots=file.roots,
    )


def _load_robot(config: SceneConfig, folder: Path | None, where: str) -> Robot | None:
    if config.robot is None:
        return None
    at = f"{where}: robot"
    robot = build_robot(robot_urdf(config.robot, folder, where=at), config.robot, where=at)
    robot.model.gravity.linear = np.array(config.gravity_m_s2)
    return robot


def _read(path: Path) -> str:
    where = path.name or str(path)
    if not is_file(path):
        mend = f"give a YAML file or one of {', '.join(builtin_scenes())}"
        raise SceneError("is not a file", where=where, mend=mend)
    try:
        if path.stat().st_size > MAX_BYTES:
            what = f"has {path.stat().st_size} bytes, the limit is {MAX_BYTES}"
            raise SceneError(what, where=where, mend="a scene needs a few kilobytes")
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError("is not UTF-8 text", where=where, mend="save it as UTF-8") from error
    except OSError as error:
        raise SceneError("cannot be read", where=where, mend="check its permissions") from error
