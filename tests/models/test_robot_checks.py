"""Robots of a scene that contradict their URDF, and gaits that move fingers."""

import json
from typing import Any

import numpy as np
import pytest

from pivotgait.exceptions import InputError, SceneError, UnknownNameError, UrdfError
from pivotgait.models import export_scene, parse_scene, urdf_root
from pivotgait.models.robot_config import RobotConfig
from pivotgait.models.robot_loading import build_robot

COBRA = (urdf_root() / "cobra_s800_shadow" / "cobra_s800_shadow.urdf").read_text()
INDEX, MIDDLE = ([f"{f}J{n}" for n in (4, 3, 2, 1)] for f in ("FF", "MF"))
THUMB = [f"THJ{n}" for n in (5, 4, 3, 2, 1)]


def finger(tip: str, radius: float, joints: list[str]) -> dict[str, Any]:
    return {"tip_frame": tip, "tip_radius_m": radius, "pad": [0, -1, 0], "joints": joints}


def fields(*, index: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    return {
        "urdf": "cobra_s800_shadow",
        "palm": "palm",
        "fingers": {
            "index": {**finger("fftip", 0.006, INDEX), **(index or {})},
            "middle": finger("mftip", 0.006, MIDDLE),
            "thumb": finger("thtip", 0.0075, THUMB),
        },
        "couplings": [["FFJ1", "FFJ2"]],
        **changes,
    }


def build(text: str = COBRA, **changes: Any) -> Any:
    config = RobotConfig.model_validate_json(json.dumps(fields(**changes)))
    return build_robot(text, config, where="s.yaml: robot")


def test_a_good_robot_has_each_joint_in_one_place() -> None:
    robot = build()
    of_fingers = [column for each in robot.fingers.values() for column in each.columns]
    assert sorted([*of_fingers, *robot.palm_columns]) == list(range(robot.nv))
    assert [robot.joint_names[i] for i in robot.palm_columns] == [
        "J1",
        "J2",
        "J3",
        "J4",
        "WRJ2",
        "WRJ1",
    ]
    assert robot.within_limits(robot.home)
    assert robot.couplings == ((robot.joint_names.index("FFJ1"), robot.joint_names.index("FFJ2")),)
    assert robot.never_touch == ()
    for each in robot.fingers.values():
        assert np.linalg.norm(each.pad) == pytest.approx(1.0)


BAD: dict[str, tuple[dict[str, Any], type[InputError], str]] = {
    "misspelt palm": (
        {"palm": "plam"},
        UnknownNameError,
        "robot.palm: unknown link 'plam' - did you mean 'palm'?",
    ),
    "a joint as palm": ({"palm": "WRJ1"}, UnknownNameError, "unknown link 'WRJ1'"),
    "misspelt tip": (
        {"index": {"tip_frame": "fftipp"}},
        UnknownNameError,
        "fingers.index.tip_frame: unknown link 'fftipp' - did you mean 'fftip'?",
    ),
    "misspelt joint": (
        {"index": {"joints": ["FFJ4", "FFJ3", "FFJ2", "FFJ01"]}},
        UnknownNameError,
        "fingers.index.joints: unknown moving joint 'FFJ01' - did you mean 'FFJ1'?",
    ),
    "fixed joint": (
        {"index": {"joints": [*INDEX, "fftip_mount"]}},
        UnknownNameError,
        "unknown moving joint 'fftip_mount'",
    ),
    "joint of another finger": (
        {"index": {"joints": [*INDEX[:3], "MFJ1"]}},
        SceneError,
        "joint 'MFJ1' does not lie between palm and 'fftip'",
    ),
    "joint of the arm": (
        {"index": {"joints": ["J4", *INDEX]}},
        SceneError,
        "'J4' does not lie between palm and 'fftip' - from the palm outwards they are: FFJ4, FFJ3,",
    ),
    "joint left out": (
        {"index": {"joints": INDEX[:3]}},
        SceneError,
        "joint 'FFJ1' between palm and 'fftip' is missing",
    ),
    "joints out of order": (
        {"index": {"joints": INDEX[::-1]}},
        SceneError,
        "joints are out of order or named twice",
    ),
    "joint twice": (
        {"index": {"joints": [*INDEX, "FFJ1"]}},
        SceneError,
        "joints are out of order or named twice",
    ),
    "tip that its joints do not move": (
        {"index": {"tip_frame": "mftip"}},
        SceneError,
        "joint 'FFJ4' does not lie between palm and 'mftip'",
    ),
    "tip in the arm": (
        {"index": {"tip_frame": "flange"}},
        SceneError,
        "'flange' is not carried by the palm 'palm'",
    ),
    "palm beyond the finger": (
        {"palm": "fftip"},
        SceneError,
        "joint 'FFJ4' does not lie between palm and 'fftip'",
    ),
    "palm before the wrist": (
        {"palm": "forearm"},
        SceneError,
        "joint 'WRJ2' between palm and 'fftip' is missing",
    ),
    "wrong radius": (
        {"index": {"tip_radius_m": 0.0061}},
        SceneError,
        "tip_radius_m: 0.0061 m is not that of the sphere of 'fftip' - the URDF says 0.006 m",
    ),
    "radius off by 2 nm": (
        {"index": {"tip_radius_m": 0.006000002}},
        SceneError,
        "is not that of the sphere",
    ),
    "tip without sphere": (
        {"index": {"tip_frame": "ffdistal"}},
        SceneError,
        "link 'ffdistal' has no collision sphere about its origin",
    ),
    "pad without direction": (
        {"index": {"pad": [0, 0, 0]}},
        SceneError,
        "fingers.index.pad: has no direction",
    ),
    "pad that vanishes when squared": (
        {"index": {"pad": [1e-200, 0, 0]}},
        SceneError,
        "fingers.index.pad: has no direction",
    ),
    "two fingers on one chain": (
        {"fingers": {"a": finger("fftip", 0.006, INDEX), "b": finger("fftip", 0.006, INDEX)}},
        SceneError,
        "'a' and 'b' share joint 'FFJ4'",
    ),
    "finger left to itself": (
        {"fingers": {name: fields()["fingers"][name] for name in ("index", "thumb")}},
        SceneError,
        "joint 'MFJ4' moves neither the palm nor a finger's tip - lock it under robot.fixed",
    ),
    "home above the limit": (
        {"home": {"J1": 2.0}},
        SceneError,
        "robot.home.J1: 2 is outside the limits [-1.832",
    ),
    "home of an unknown joint": (
        {"home": {"J11": 0.0}},
        UnknownNameError,
        "robot.home: unknown moving joint 'J11'",
    ),
    "home against a coupling": (
        {"home": {"FFJ1": 1.2}},
        SceneError,
        "robot.home: FFJ1 = 1.2 exceeds FFJ2 = 0.785",
    ),
    "coupling of an unknown joint": (
        {"couplings": [["FFJ1", "FFJ9"]]},
        UnknownNameError,
        "robot.couplings[0]: unknown moving joint 'FFJ9'",
    ),
    "coupling with itself": (
        {"couplings": [["FFJ1", "FFJ1"]]},
        SceneError,
        "robot.couplings[0]: pairs 'FFJ1' with itself",
    ),
    "never_touch of an unknown link": (
        {"never_touch": [["palm", "fotearm"]]},
        UnknownNameError,
        "robot.never_touch[0]: unknown link 'fotearm' - did you mean 'forearm'?",
    ),
    "never_touch of one link": (
        {"never_touch": [["palm", "palm"]]},
        SceneError,
        "pairs 'palm' with itself",
    ),
}


@pytest.mark.parametrize(("changes", "kind", "message"), BAD.values(), ids=BAD)
def test_bad_robot(changes: dict[str, Any], kind: type[InputError], message: str) -> None:
    with pytest.raises(kind) as caught:
        build(**changes)
    assert type(caught.value) is kind
    assert message in str(caught.value)
    assert str(caught.value).startswith("s.yaml: robot")
    assert caught.value.exit_code == 2
    assert caught.value.mend


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="revolute"', 'type="continuous"', "continuous joints are not supported"),
        (' velocity="2"', "", "has no 'velocity'"),
        (' effort="1"', "", "has no 'effort'"),
    ],
)
def test_joints_that_no_plan_can_use(old: str, new: str, message: str) -> None:
    assert old in COBRA
    with pytest.raises(UrdfError, match=message):
        build(COBRA.replace(old, new, 1))


KNIFE = export_scene("knife_allegro")
GAIT = KNIFE[KNIFE.index("    - {kind: lift") :]
LIFT, _, ADD, REMOVE, _, ADD_FAR = GAIT.splitlines()


def move(contact: str) -> str:
    return f"    - {{kind: relocation, contact: {contact}}}"


def with_gait(*phases: str) -> str:
    return KNIFE.replace(GAIT, "\n".join(phases) + "\n")


def test_a_gait_that_moves_its_free_fingers() -> None:
    far = "index_edge_near"
    gait = (LIFT, move("middle_flat"), ADD, REMOVE, move("index_edge"), move(far), ADD_FAR)
    scene = parse_scene(with_gait(*gait))
    moved = [phase.contact for phase in scene.gaits["default"] if phase.kind == "relocation"]
    assert moved == ["middle_flat", "index_edge", far]


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        (
            with_gait(LIFT, move("index_edge_near")),
            SceneError,
            "gaits.default[1].contact: finger 'index' holds the tool at 'index_edge' - remove it",
        ),
        (
            with_gait(LIFT, ADD, REMOVE, move("index_edge"), ADD_FAR),
            SceneError,
            "finger 'index' was moved to 'index_edge', not to 'index_edge_near'",
        ),
        (with_gait(LIFT, move("middle_flt")), UnknownNameError, "did you mean 'middle_flat'?"),
        (
            with_gait(move("middle_flat"), LIFT),
            SceneError,
            "gaits.default[0]: starts with kind relocation",
        ),
        (
            KNIFE.replace("{finger: middle, along", "{finger: ring, along"),
            UnknownNameError,
            "contacts.middle_flat.finger: unknown finger 'ring'",
        ),
        (
            KNIFE.replace("fixed: {joint_8.0: 0.0, ", "fixed: {"),
            SceneError,
            "joint 'joint_8.0' moves neither the palm nor a finger's tip",
        ),
        (KNIFE.replace("frame: tool0", "frame: tool1"), UnknownNameError, "did you mean 'tool0'"),
        (KNIFE.replace("  mount:", "  urdf: cobra_s800_shadow\n  mount:"), SceneError, "has both"),
    ],
)
def test_bad_scene_of_a_robot(text: str, kind: type[InputError], message: str) -> None:
    assert text != KNIFE
    with pytest.raises(kind) as caught:
        parse_scene(text)
    assert type(caught.value) is kind
    assert message in str(caught.value)
