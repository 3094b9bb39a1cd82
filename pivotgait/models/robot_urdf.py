"""The one URDF text of a scene's robot, which a plan carries with it."""

from __future__ import annotations

from pathlib import Path

from pivotgait.exceptions import SceneError
from pivotgait.models.robot_config import BaseConfig, RobotConfig
from pivotgait.models.robot_joining import join, lock, place, weigh_frames
from pivotgait.models.robot_parts import reduced, write
from pivotgait.models.urdf import UrdfSummary, read_urdf
from pivotgait.models.urdf_files import find_urdf


def robot_urdf(config: RobotConfig, folder: Path | None, *, where: str) -> str:
    """URDF text of the robot a scene asks for: primitives only, rooted in the world frame.

    A file that is that already is taken word for word. Otherwise links and joints keep their
    names, except those of a mounted hand which the arm has, too: they get the prefix ``hand_``.

    Args:
        config: the scene's fields.
        folder: of the scene file, in which relative paths start.
        where: name of the scene's field in messages.

    Raises:
        SceneError: for both or none of ``urdf`` and ``mount``, a path outside the folders, or a
            locked joint outside its limits.
        UrdfError: for a file that must not reach the native parsers.
        UnknownNameError: for a model, link or joint that does not exist.
    """
    if (config.urdf is None) == (config.mount is None):
        what = "names no URDF" if config.urdf is None else "has both urdf and mount"
        raise SceneError(what, where=where, mend="give either urdf or mount")
    if config.mount is not None:
        mount, at = config.mount, f"{where}.mount"
        arm, hand = (
            reduced(_read(given, folder, f"{at}.{part}"), where=f"{at}.{part}")
            for part, given in (("arm", mount.arm), ("hand", mount.hand))
        )
        robot = join(arm, hand, mount, where=at)
    else:
        at = f"{where}.urdf"
        summary = _read(str(config.urdf), folder, at)
        if not config.fixed and config.base == BaseConfig() and not _has_files(summary):
            return summary.text
        robot = reduced(summary, where=at)
    lock(robot, config.fixed, where=f"{where}.fixed")
    place(robot, config.base)
    weigh_frames(robot)
    return write(robot)


def _read(given: str, folder: Path | None, at: str) -> UrdfSummary:
    file = find_urdf(given, folder, kind="robot", at=at)
    return read_urdf(file.path, file.roots)


def _has_files(summary: UrdfSummary) -> bool:
    shapes = [each for link in summary.links.values() for each in link.collisions + link.visuals]
    return any(shape.kind == "mesh" for shape in shapes)
