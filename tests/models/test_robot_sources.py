"""Where a robot's URDFs come from, and what cannot be joined."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import SceneError, UnknownNameError, UrdfError
from pivotgait.models.urdf import check_urdf
from tests.models.robot_cases import HAND_PATH, UR5, UR5_PATH, fields, text_of


def test_a_file_of_primitives_is_taken_word_for_word() -> None:
    text = text_of(mount=None, urdf="allegro_right_hand", base=None, fixed=None)
    assert text == HAND_PATH.read_text()
    placed = text_of(mount=None, urdf="allegro_right_hand", fixed=None)
    assert check_urdf(placed, where="r").mass == check_urdf(text, where="r").mass


def test_a_file_with_meshes_alone_becomes_primitives() -> None:
    text = text_of(mount=None, urdf=UR5, base=None, fixed=None)
    assert "<mesh" not in text
    assert check_urdf(text, where="r").root == "world"
    model, source = pin.buildModelFromXML(text), pin.buildModelFromUrdf(str(UR5_PATH))
    q = np.linspace(-1, 1, 6)
    upper = [np.triu(pin.crba(each, each.createData(), q)) for each in (model, source)]
    np.testing.assert_array_equal(*upper)


def test_paths_start_in_the_scene_folder(tmp_path: Path) -> None:
    shutil.copy(HAND_PATH, tmp_path / "mine.urdf")
    text = text_of(tmp_path, mount=None, urdf="mine.urdf", base=None, fixed=None)
    assert text == HAND_PATH.read_text()


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        ("ur5", UnknownNameError, r"robot.urdf: unknown robot 'ur5'"),
        ("alegro_right_hand", UnknownNameError, "did you mean 'allegro_right_hand'"),
        ("../../../etc/passwd.urdf", SceneError, "is outside the scene's folder"),
        ("/etc/passwd.urdf", SceneError, "is outside the scene's folder"),
        ("none.urdf", UrdfError, "is not a file"),
        ("a\0.urdf", SceneError, "is not a path"),
        ("example-robot-data:../../x.urdf", SceneError, "leaves example-robot-data"),
        ("example-robot-data:/etc/passwd", SceneError, "leaves example-robot-data"),
        (
            "example-robot-data:ur_description/urdf/ur5robot.urdf",
            SceneError,
            "did you mean 'ur_description/urdf/ur5_robot.urdf'",
        ),
        ("example-robot-data:zzz", SceneError, "give <robot>/urdf/<file>.urdf"),
        ("example-robot-data:ur_description/README.md", SceneError, "has no URDF"),
        (
            "example-robot-data:allegro_hand_description/urdf/allegro_right_hand.urdf",
            UrdfError,
            "breaks the triangle inequality",
        ),
        ("example-robot-data:panda_description/urdf/panda.urdf", UrdfError, "mimic joints"),
    ],
)
def test_a_name_that_leads_nowhere(
    given: str, kind: type[Exception], message: str, tmp_path: Path
) -> None:
    with pytest.raises(kind, match=message):
        text_of(tmp_path, mount=None, urdf=given)


def test_without_the_package_its_robots_are_not_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.path", [])
    with pytest.raises(SceneError, match="pip install example-robot-data"):
        text_of()


@pytest.mark.parametrize(
    ("changes", "kind", "message"),
    [
        ({"urdf": "cobra_s800_shadow"}, SceneError, "has both urdf and mount"),
        ({"mount": None}, SceneError, "names no URDF - give either urdf or mount"),
        (
            {"mount": {**fields()["mount"], "frame": "tol0"}},
            UnknownNameError,
            r"robot.mount.frame: unknown link 'tol0' - did you mean 'tool0'",
        ),
        (
            {"fixed": {"joint_8": 0}},
            UnknownNameError,
            "robot.fixed: unknown moving joint 'joint_8'",
        ),
        ({"fixed": {"mount": 0}}, UnknownNameError, "unknown moving joint 'mount'"),
        (
            {"fixed": {"joint_9.0": 1.7}},
            SceneError,
            r"robot.fixed.joint_9.0: 1.7 is outside the limits \[-0.196, 1.61\]",
        ),
    ],
)
def test_parts_that_cannot_be_joined(
    changes: dict[str, Any], kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind, match=message):
        text_of(**changes)
