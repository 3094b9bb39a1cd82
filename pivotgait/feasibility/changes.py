"""A scene with other values of some parameters, named by dotted paths into its YAML file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.models import Scene, revise_scene

MASS_SCALE = "tool.mass_scale"
"""The one parameter that is no field of the scene: factor of the tool's mass and inertia."""
LIFT_TARGET = {f"tool.{each}": f"lift.to.{each}" for each in ("pitch_deg", "roll_deg", "yaw_deg")}
PHASES = ("lift", "addition", "removal", "relocation")
HIDDEN = {"schema", "name", "description", "gaits", "tool", "validation"}
"""Fields that no message offers."""
Value = float | str


class Variants:
    """Scenes that differ from one in the values of some parameters.

    A parameter is a path such as ``table.friction``, ``contacts.thumb_spine.along_m`` or
    ``contacts.thumb_spine.normal_force_N.max``; ``*`` stands for every key
    (``contacts.*.friction``). ``lift``, ``addition``, ``removal`` and ``relocation`` stand for all
    phases of that kind (``removal.duration_s``), ``tool.pitch_deg``, ``tool.roll_deg`` and
    ``tool.yaw_deg`` for the lift's target, ``tool.mass_scale`` for a factor of mass and inertia.

    Args:
        scene: to start from.
        folder: in which relative URDF paths of the scene start.
    """

    def __init__(self, scene: Scene, folder: Path | None = None) -> None:
        self.scene, self._folder = scene, folder
        self._fields = json.dumps(scene.config.model_dump(mode="json", by_alias=True))

    def scene_with(self, changes: Mapping[str, Value]) -> Scene:
        """The scene after some changes.

        Raises:
            SceneError: the values make no scene.
            UnknownNameError: no such parameter; lists the keys at the place of the first
                unknown one.
            InputError: a path that ends in no single number or name.
        """
        fields: dict[str, Any] = json.loads(self._fields)
        scale = 1.0
        for path, value in changes.items():
            if path == MASS_SCALE:
                scale = _positive(value)
                continue
            for node, key in _leaves(fields, path):
                whole = isinstance(node[key], int) and isinstance(value, float)
                node[key] = int(value) if whole and float(value).is_integer() else value
        scene = self.scene
        if any(path != MASS_SCALE for path in changes):
            scene = revise_scene(scene, fields, where=scene.name, folder=self._folder)
        tool = scene.tool
        heavier = replace(tool, mass=scale * tool.mass, inertia=scale * tool.inertia)
        return scene if scale == 1.0 else replace(scene, tool=heavier)


def _positive(value: Value) -> float:
    if isinstance(value, str) or not 0.0 < value < float("inf"):
        raise InputError(f"must be a number > 0, got {value}", where=MASS_SCALE, mend="give 1.2")
    return float(value)


def _leaves(fields: dict[str, Any], path: str) -> Iterator[tuple[Any, Any]]:
    """The containers and keys of every value that a path names."""
    keys = LIFT_TARGET.get(path, path).split(".")
    nodes: list[Any] = [fields]
    if keys[0] in PHASES:
        kind = keys.pop(0)
        gaits = fields["gaits"].values()
        nodes = [phase for gait in gaits for phase in gait if phase["kind"] == kind]
    for depth, key in enumerate(keys):
        last = depth == len(keys) - 1
        found = [(node, each) for node in nodes for each in _matching(node, key)]
        if not found:
            known = sorted({str(each) for node in nodes for each in _keys(node)} - HIDDEN)
            more = () if depth else (*PHASES, *LIFT_TARGET, MASS_SCALE)
            raise UnknownNameError("parameter", path, (*known, *more), where="--set")
        for node, each in found if last else ():
            if isinstance(node[each], dict | list | bool | None):
                what, mend = f"{path!r} is not a single number or name", "go on to one of its keys"
                raise InputError(what, where="--set", mend=mend)
            yield node, each
        nodes = [node[each] for node, each in found]


def _matching(node: Any, key: str) -> Iterator[Any]:
    return (each for each in _keys(node) if key in ("*", str(each)))


def _keys(node: Any) -> Iterator[Any]:
    if isinstance(node, dict):
        yield from node
    elif isinstance(node, list):
        yield from range(len(node))
