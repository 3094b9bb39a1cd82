"""Where a scene's URDF is: a built-in model, beside the scene file, or in example-robot-data."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from pivotgait.exceptions import SceneError, UnknownNameError
from pivotgait.models.paths import is_file, model_names, urdf_root

EXAMPLE_ROBOT_DATA = "example-robot-data:"
"""Prefix of a path below the robots of the package of that name, such as
``example-robot-data:ur_description/urdf/ur5_robot.urdf``."""


@dataclass(frozen=True)
class UrdfFile:
    """A URDF file and where its meshes may lie.

    Attributes:
        path: of the file, inside one of the allowed folders.
        roots: folders in which its meshes may lie, besides its own.
    """

    path: Path
    roots: tuple[Path, ...]


def find_urdf(given: str, folder: Path | None, *, kind: str, at: str) -> UrdfFile:
    """The URDF that a scene names.

    Args:
        given: name of a built-in model, path relative to ``folder`` or the built-in models, or
            ``example-robot-data:`` and a path below that package's robots.
        folder: of the scene file; without it only the other two are searched.
        kind: what is sought, in messages.
        at: the scene's field, in messages.

    Raises:
        UnknownNameError: for a name that no built-in model has.
        SceneError: for a path that leaves the folders or is none.
    """
    if "\0" in given:
        raise SceneError("is not a path", where=at, mend="give a name or a relative path")
    if given.startswith(EXAMPLE_ROBOT_DATA):
        return _example(given.removeprefix(EXAMPLE_ROBOT_DATA), at)
    roots = (urdf_root(),) if folder is None else (folder, urdf_root())
    if given in model_names():
        return UrdfFile(urdf_root() / given / f"{given}.urdf", roots)
    if not given.endswith(".urdf"):
        raise UnknownNameError(kind, given, model_names(), where=at)
    resolved = [root.resolve() for root in roots]
    candidates = [root / given for root in resolved]
    candidates = [path for path in candidates if is_file(path)] or candidates
    inside = [
        path
        for candidate in candidates
        if any((path := candidate.resolve()).is_relative_to(root) for root in resolved)
    ]
    if not inside:
        mend = "put the URDF beside the scene file and give its relative path"
        raise SceneError(f"{given!r} is outside the scene's folder", where=at, mend=mend)
    return UrdfFile(inside[0], roots)


def example_robots() -> Path | None:
    """Folder with the robots of the package example-robot-data; None if it is not installed."""
    for entry in sys.path:
        robots = Path(entry) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if robots.is_dir():
            return robots.resolve()
    return None


def _example(given: str, at: str) -> UrdfFile:
    robots = example_robots()
    if robots is None:
        mend = "pip install example-robot-data"
        raise SceneError("needs the package example-robot-data", where=at, mend=mend)
    path = (robots / given).resolve()
    if not path.is_relative_to(robots):
        mend = "give a path below the package's robots"
        raise SceneError(f"{given!r} leaves example-robot-data", where=at, mend=mend)
    if path.suffix != ".urdf" or not is_file(path):
        known = sorted(each.relative_to(robots).as_posix() for each in robots.rglob("*.urdf"))
        near = get_close_matches(given, known, n=1, cutoff=0.4)
        mend = f"did you mean {near[0]!r}?" if near else "give <robot>/urdf/<file>.urdf"
        raise SceneError(f"example-robot-data has no URDF {given!r}", where=at, mend=mend)
    # Its meshes are package://example-robot-data/robots/..., looked up in a root of that name.
    return UrdfFile(path, (robots.parent,))
