"""A scene with other values of some parameters, named by dotted paths into its YAML file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pivotgait.models import Scene, revise_scene
from pivotgait.models.parameters import (
    EFFORT_SCALE,
    MASS_SCALE,
    Fields,
    Place,
    Value,
    places_of,
    set_values,
    with_scaled_efforts,
    with_scaled_mass,
)

_SCALES = {MASS_SCALE: with_scaled_mass, EFFORT_SCALE: with_scaled_efforts}
"""Parameters that are no fields of the scene: 1 as it is."""


class Variants:
    """Scenes that differ from one in the values of some parameters.

    See :func:`pivotgait.models.parameters.places_of` for the parameters' names; besides,
    ``tool.mass_scale`` is a factor of mass and inertia, ``robot.effort_scale`` one of the torque
    limits of all joints.

    Args:
        scene: to start from.
        folder: in which relative URDF paths of the scene start.
    """

    def __init__(self, scene: Scene, folder: Path | None = None) -> None:
        self.scene, self._folder = scene, folder
        fields = scene.config.model_dump(mode="json", by_alias=True)
        self._fields = json.dumps(fields)
        self._places: dict[str, tuple[Place, ...]] = {}

    def value(self, parameter: str) -> Value:
        """The value of a parameter now; of several, the first.

        Raises:
            UnknownNameError, SceneError: see :meth:`scene_with`.
        """
        if parameter in _SCALES:
            return 1.0
        node = json.loads(self._fields)
        for key in self._places_of(parameter)[0]:
            node = node[key]
        found: Value = node
        return found

    def scene_with(self, changes: Mapping[str, Value]) -> Scene:
        """The scene after some changes.

        Raises:
            SceneError: the values make no scene, or a path ends in no single number or name.
            UnknownNameError: no such parameter; lists the keys at the place of the first
                unknown one.
        """
        scene, named = self.scene, {k: v for k, v in changes.items() if k not in _SCALES}
        if named:
            fields: Fields = json.loads(self._fields)
            for path, value in named.items():
                set_values(fields, self._places_of(path), value)
            scene = revise_scene(scene, fields, where=scene.name, folder=self._folder)
        for parameter, scaled in _SCALES.items():
            scale = changes.get(parameter, 1.0)
            scene = scene if scale == 1.0 else scaled(scene, scale)
        return scene

    def _places_of(self, path: str) -> tuple[Place, ...]:
        if path not in self._places:
            self._places[path] = places_of(path, json.loads(self._fields), where="parameter")
        return self._places[path]
