"""The scenes of a sweep's cells: one scene with other values of some parameters."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from pivotgait.models import Scene, revise_scene
from pivotgait.models.parameters import (
    MASS_SCALE,
    Fields,
    Place,
    Value,
    places_of,
    set_values,
    with_scaled_mass,
)
from pivotgait.sweeps.study_config import StudyConfig


def base_fields(config: StudyConfig, scene: Scene) -> Fields:
    """The scene's fields with the study's gait alone, named ``default``.

    What is not computed is cut off, so that it cannot contradict a cell's values: the gait ends
    with its lift for ``compute: static``, with its first removal for ``compute: removal``.
    """
    fields: Fields = scene.config.model_dump(mode="json", by_alias=True)
    gait = list(fields["gaits"][config.gait or next(iter(fields["gaits"]))])
    last = {"static": "lift", "removal": "removal"}.get(config.compute)
    kinds = [phase["kind"] for phase in gait]
    if last in kinds:
        gait = gait[: kinds.index(last) + 1]
    fields["gaits"] = {"default": gait}
    return fields


class SceneFamily:
    """Makes the scene of a cell from its values.

    Args:
        config: of the study.
        scene: before anything is varied.
        folder: in which the scene's relative URDF paths start.
    """

    def __init__(self, config: StudyConfig, scene: Scene, folder: Path | None) -> None:
        fields = base_fields(config, scene)
        self._text = json.dumps(fields)
        self._scene, self._folder = scene, folder
        self._fixed = dict(config.set)
        self._places: dict[str, tuple[Place, ...]] = {
            name: places_of(name, fields, where=name) for name in (*config.set, *config.axes)
        }

    def scene(self, values: Mapping[str, Value]) -> Scene:
        """The scene with these values of the axes' parameters.

        Raises:
            SceneError, UnknownNameError: there is no such scene.
        """
        fields: Fields = json.loads(self._text)
        given: dict[str, Value] = {**self._fixed, **values}
        for name, value in given.items():
            set_values(fields, self._places[name], value)
        scene = revise_scene(self._scene, fields, where="cell", folder=self._folder)
        scale = given.get(MASS_SCALE)
        return scene if scale is None else with_scaled_mass(scene, scale)
