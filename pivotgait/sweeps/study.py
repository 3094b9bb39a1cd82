"""A study: read, checked against its scene, and ready to be carried out anywhere."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pivotgait.exceptions import UnknownNameError
from pivotgait.models import Scene, builtin_scenes, export_scene, parse_scene
from pivotgait.models.builtin_files import BuiltinFiles
from pivotgait.models.paths import is_file
from pivotgait.models.scene_errors import as_scene_error
from pivotgait.models.scene_yaml import MAX_BYTES, read_yaml
from pivotgait.sweeps.axes import Axis, make_axis
from pivotgait.sweeps.cells import CellSpace
from pivotgait.sweeps.errors import StudyError, of_a_study
from pivotgait.sweeps.study_checks import check_study
from pivotgait.sweeps.study_config import StudyConfig

RESULTS_SCHEMA = "pivotgait-results/2"
"""Of the columns and their meaning; a change makes every cell a new one."""
_BUILTIN = BuiltinFiles("study", "pivotgait.sweeps", "studies")
_EXAMPLE = "pivotgait sweep --export knife_friction"


@dataclass(frozen=True, eq=False)
class Study:
    """What to vary, what to compute, and on which scene.

    Attributes:
        config: the file's fields.
        scene_text: the scene's YAML.
        folder: in which the scene's relative URDF paths start, None for a built-in scene.
        digest: of all that the cells' results depend on but the values of the axes (SHA-256).
    """

    config: StudyConfig
    scene_text: str
    folder: Path | None
    digest: str

    @cached_property
    def cells(self) -> CellSpace:
        """Its cells."""
        config = self.config
        axes = tuple(Axis(name, axis) for name, axis in config.axes.items())
        return CellSpace(axes, config.draws or 1, config.seed)

    @cached_property
    def scene(self) -> Scene:
        """The scene as it is before anything is varied.

        Raises:
            SceneError, UrdfError, UnknownNameError: it cannot be loaded here.
        """
        return parse_scene(self.scene_text, where=self.config.scene, folder=self.folder)

    def to_json(self) -> str:
        """Everything another process needs to make the same study."""
        data = {
            "study": self.config.model_dump(mode="json", by_alias=True),
            "scene": self.scene_text,
            "folder": str(self.folder.resolve()) if self.folder else None,
            "digest": self.digest,
        }
        return json.dumps(data)  # keys in their order: that of the axes counts

    @classmethod
    def from_json(cls, text: str) -> Study:
        """The study that :meth:`to_json` told; its scene is not loaded yet."""
        data = json.loads(text)
        config = StudyConfig.model_validate_json(json.dumps(data["study"]))
        folder = Path(data["folder"]) if data["folder"] else None
        return cls(config, data["scene"], folder, data["digest"])

    def check_digest(self) -> None:
        """Check that the scene and its URDFs are here what they were where the study was made.

        Raises:
            StudyError: they are not.
            SceneError, UrdfError, UnknownNameError: the scene cannot be loaded here.
        """
        if digest_of(self.config, self.scene) != self.digest:
            mend = "give all workers the same version of pivotgait and of the scene's files"
            raise StudyError("is another one for the worker", where=self.config.name, mend=mend)


def digest_of(config: StudyConfig, scene: Scene) -> str:
    """SHA-256 of all that cells' results depend on but the values of the axes."""
    kept = config.model_dump(mode="json", by_alias=True)
    for name in ("schema", "name", "description", "scene", "axes", "draws"):
        del kept[name]
    content = {
        "results": RESULTS_SCHEMA,
        "study": kept,
        "scene": scene.config.model_dump(mode="json", by_alias=True),
        "tool": scene.tool.urdf,
        "robot": scene.robot.urdf if scene.robot else None,
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def builtin_studies() -> tuple[str, ...]:
    """Names of the studies that come with the package, sorted."""
    return _BUILTIN.names()


def export_study(name: str) -> str:
    """YAML text of a built-in study.

    Raises:
        UnknownNameError: listing the built-in studies.
    """
    return _BUILTIN.text(name)


def load_study(study: str | Path) -> Study:
    """Load a study.

    Args:
        study: a built-in name, or the path of a YAML file.

    Raises:
        StudyError: naming the field and the way to mend it.
        UnknownNameError: a study, scene, parameter or contact that does not exist.
        SceneError, UrdfError: from the scene.
    """
    if isinstance(study, str) and study in builtin_studies():
        return parse_study(export_study(study), where=f"{study}.yaml")
    path = Path(study)
    if path.name == str(study) and path.suffix == "" and not is_file(path):
        raise UnknownNameError("study", str(study), builtin_studies())
    return parse_study(_read(path, "study"), where=path.name, folder=path.parent)


def parse_study(text: str, *, where: str = "study", folder: Path | None = None) -> Study:
    """Load a study from its YAML text.

    Args:
        text: the whole text.
        where: its name in messages.
        folder: in which a relative path of the scene starts; without it only built-in scenes
            are found.

    Raises:
        StudyError, UnknownNameError, SceneError, UrdfError: as :func:`load_study`.
    """
    with of_a_study():
        config = _validate(read_yaml(text, where=where, example=_EXAMPLE), where)
    for name, axis in config.axes.items():
        make_axis(name, axis, where=f"{where}: axes.{name}")
    scene_text, scene_folder = _scene_text(config.scene, folder, f"{where}: scene")
    scene = parse_scene(scene_text, where=config.scene, folder=scene_folder)
    study = Study(config, scene_text, scene_folder, digest_of(config, scene))
    check_study(config, scene, study.cells, where)
    return study


def _validate(data: dict[str, Any], where: str) -> StudyConfig:
    try:
        return StudyConfig.model_validate_json(json.dumps(data, default=str))
    except ValidationError as error:
        raise as_scene_error(error, StudyConfig, where) from error
    except (TypeError, ValueError, RecursionError) as error:
        mend = "use plain text as keys and no alias to itself"
        raise StudyError(f"cannot be used: {error}", where=where, mend=mend) from error


def _scene_text(scene: str, folder: Path | None, at: str) -> tuple[str, Path | None]:
    if scene in builtin_scenes():
        return export_scene(scene), None
    path = Path(scene)
    if folder is None or (path.name == scene and path.suffix == ""):
        raise UnknownNameError("scene", scene, builtin_scenes(), where=at)
    file = folder / path
    if not is_file(file):
        mend = "give a built-in scene's name or a path relative to the study"
        raise StudyError(f"{scene!r} is not a file", where=at, mend=mend)
    return _read(file, "scene"), file.parent


def _read(path: Path, kind: str) -> str:
    where = path.name or str(path)
    if not is_file(path):
        known = ", ".join(builtin_studies())
        raise StudyError("is not a file", where=where, mend=f"give a YAML file or one of {known}")
    try:
        if path.stat().st_size > MAX_BYTES:
            what = f"has {path.stat().st_size} bytes, the limit is {MAX_BYTES}"
            raise StudyError(what, where=where, mend=f"is it a {kind}?")
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise StudyError("is not UTF-8 text", where=where, mend="save it as UTF-8") from error
    except OSError as error:
        raise StudyError("cannot be read", where=where, mend="check its permissions") from error
