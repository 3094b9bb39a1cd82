"""Scenes that cannot be used: the error's type, exit code and words."""

import re
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pivotgait.exceptions import InputError, SceneError, UnknownNameError, UrdfError
from pivotgait.models import export_scene, load_scene, parse_scene

KNIFE = export_scene("knife")
GAIT = KNIFE[KNIFE.index("    - {kind: lift") :]
LIFT, TO_MIDDLE, ADD, REMOVE, TO_NEAR, ADD_NEAR = GAIT.splitlines()
EDGE, MIDDLE, TABLE_MIN, FINGER_MIN = (
    re.search(pattern, KNIFE).group(1)  # type: ignore[union-attr]
    for pattern in (
        r"index_edge: ({finger: index, along_m: [\d.]+, around_deg: 180,)",
        r"middle_flat: {finger: middle, (along_m: [\d.]+)",
        r"(min: [\d.]+), max: 6.0",
        r"(min: [\d.]+, max: 4.0)",
    )
)

# what to replace in the knife's scene, with what, the error's type, a part of its message
BAD: dict[str, tuple[str, str, type[InputError], str]] = {
    "other schema": ("scene/1", "scene/9", SceneError, "schema: unknown value"),
    "no schema": ("schema: pivotgait-scene/1\n", "", SceneError, "schema: is missing - add it"),
    "unknown key": (
        "clearance_m:",
        "clearence_m:",
        SceneError,
        "clearence_m: unknown key 'clearence_m' - did you mean 'clearance_m'?",
    ),
    "unknown key in a contact": (
        EDGE,
        EDGE + " fricton: 1,",
        SceneError,
        "contacts.index_edge.fricton: unknown key 'fricton' - did you mean 'friction'?",
    ),
    "unknown key in a phase": (
        "duration_s: 0.8, steps: 40}",
        "duration_s: 0.8, steps: 40, stepz: 1}",
        SceneError,
        "gaits.default[2].stepz: unknown key 'stepz' - did you mean 'steps'?",
    ),
    "unknown kind": (
        "kind: addition",
        "kind: add",
        SceneError,
        "gaits.default[2]: unknown kind 'add' - use",
    ),
    "no kind": (
        "kind: addition, ",
        "",
        SceneError,
        "gaits.default[2]: has no 'kind' - add kind: lift, relocation, addition or removal",
    ),
    "zero friction": (
        EDGE + " friction: 0.8",
        EDGE + " friction: 0",
        SceneError,
        "knife.yaml: contacts.index_edge.friction: must be greater than 0, got 0",
    ),
    "friction too large": ("friction: 0.4", "friction: 4", SceneError, "must be at most 2, got 4"),
    "friction not finite": ("friction: 0.4", "friction: .nan", SceneError, "must be finite"),
    "infinite bound": ("max: 6.0", "max: .inf", SceneError, "must be finite"),
    "negative bound": (TABLE_MIN, "min: -1", SceneError, "must be at least 0, got -1"),
    "f_min > f_max": (
        TABLE_MIN,
        "min: 7",
        SceneError,
        "table.normal_force_N: min 7 N is greater than max 6 N",
    ),
    "f_min > f_max of a finger": (
        FINGER_MIN,
        "min: 9, max: 4.0",
        SceneError,
        "contacts.thumb_spine.normal_force_N: min 9 N",
    ),
    "decimal comma": ("height_m: 0.0", "height_m: 1,5", SceneError, "write a decimal point: 1.5"),
    "number in quotes": ("height_m: 0.0", "height_m: '0'", SceneError, "must be a number, got '0'"),
    "truth for number": ("height_m: 0.0", "height_m: true", SceneError, "must be a number"),
    "two numbers for three": (
        "gravity_m_s2: [0, 0, -9.81]",
        "gravity_m_s2: [0, 0]",
        SceneError,
        "gravity_m_s2[2]: is missing",
    ),
    "gravity upwards": ("-9.81", "9.81", SceneError, "gravity_m_s2: must point down"),
    "pivot off the table": (
        "pivot_m: [0.55, 0.0]",
        "pivot_m: [0.75, 0.0]",
        SceneError,
        "rest.pivot_m: the pivot [0.75, 0.0] is off the table",
    ),
    "no such tool": (
        "urdf: chef_knife",
        "urdf: chef_knive",
        UnknownNameError,
        "tool.urdf: unknown tool 'chef_knive' - did you mean 'chef_knife'?",
    ),
    "no such URDF": ("urdf: chef_knife", "urdf: a/b.urdf", UrdfError, "b.urdf: is not a file"),
    "URDF above the scene": (
        "urdf: chef_knife",
        "urdf: ../../b.urdf",
        SceneError,
        "outside the scene's folder",
    ),
    "URDF elsewhere": (
        "urdf: chef_knife",
        "urdf: /etc/b.urdf",
        SceneError,
        "outside the scene's folder",
    ),
    "no such tip": ("tip: tip", "tip: top", UnknownNameError, "unknown collision shape 'top'"),
    "box for a tip": ("tip: tip", "tip: bolster", UrdfError, "the tip 'bolster' is a box"),
    "no such handle shape": (
        "[handle, ",
        "[handel, ",
        UnknownNameError,
        "unknown collision shape 'handel' - did you mean 'handle'?",
    ),
    "no handle shapes": (
        "[handle, handle_spine, handle_edge]",
        "[]",
        SceneError,
        "tool.handle.shapes: has 0 entries, needs at least 1",
    ),
    "axis without length": ("axis: [-1, 0, 0]", "axis: [0, 0, 0]", SceneError, "axis: has no dir"),
    "zero along the axis": ("zero: [0, 0, 1]", "zero: [1, 0, 1]", SceneError, "normal to axis"),
    "axis beside the handle": ("-0.0145]", "0.2]", SceneError, "axis misses its shapes"),
    "off the handle": (
        MIDDLE,
        "along_m: 0.3",
        SceneError,
        "contacts.middle_flat: along_m 0.3 is off the handle - choose it within",
    ),
    "no such contact": (
        "contact: middle_flat",
        "contact: middle_flap",
        UnknownNameError,
        "gaits.default[1].contact: unknown contact 'middle_flap' - did you mean 'middle_flat'?",
    ),
    "no such contact to remove": (
        REMOVE,
        REMOVE.replace("index_edge", "ring"),
        UnknownNameError,
        "gaits.default[3].contact: unknown contact 'ring'",
    ),
    "no such contact to lift with": (
        "[thumb_spine, index_edge]",
        "[thumb_spine, little]",
        UnknownNameError,
        "gaits.default[0].contacts: unknown contact 'little'",
    ),
    "lift with one finger": (
        "[thumb_spine, index_edge]",
        "[thumb_spine]",
        SceneError,
        "gaits.default[0].contacts: has 1 entries, needs at least 2",
    ),
    "lift with one finger twice": (
        "[thumb_spine, index_edge]",
        "[index_edge, index_edge_near]",
        SceneError,
        "finger 'index' is in contact already, at 'index_edge'",
    ),
    "add a finger twice": (
        f"{REMOVE}\n{TO_NEAR}\n",
        "",
        SceneError,
        "finger 'index' is in contact already",
    ),
    "move a finger that holds": (REMOVE + "\n", "", SceneError, "finger 'index' holds the tool"),
    "remove what does not touch": (
        REMOVE,
        REMOVE.replace("index_edge", "index_edge_near"),
        SceneError,
        "'index_edge_near' is not in contact - contacts then: thumb_spine, index_edge, middle",
    ),
    "one finger left": (ADD + "\n", "", SceneError, "leaves 1 finger on the tool, needs 2"),
    "no lift first": (LIFT + "\n", "", SceneError, "gaits.default[0]: starts with kind relocation"),
    "a second lift": (ADD_NEAR, LIFT, SceneError, "gaits.default[5]: a lift after another phase"),
    "no phases": (GAIT, "", SceneError, "gaits.default"),
    "no gait": ("gaits:\n  default:\n" + GAIT, "gaits: {}", SceneError, "gaits"),
    "no default gait": ("  default:", "  other:", SceneError, "gaits: has no gait 'default'"),
    "one step": ("steps: 75", "steps: 1", SceneError, "must be at least 2, got 1"),
    "too many steps": ("steps: 75", "steps: 5000", SceneError, "must be at most 4096"),
    "half a step": ("steps: 75", "steps: 7.5", SceneError, "must be a whole number, got 7.5"),
    "no time": ("duration_s: 1.5", "duration_s: 0", SceneError, "must be greater than 0"),
    "lift into the table": (
        "pitch_deg: 25",
        "pitch_deg: 1",
        SceneError,
        "gaits.default[0].to: leaves the tool -",
    ),
    "lift onto the table": ("pitch_deg: 25", "pitch_deg: 2.4", SceneError, "- raise pitch_deg"),
    "unknown profile": ("quintic", "cubic", SceneError, "unknown value 'cubic' - use"),
    "unknown objective": ("objective: alignment", "objective: best", SceneError, "- use"),
    "pivot as a finger": ("finger: thumb", "finger: pivot", SceneError, "rename the finger"),
    "name with a slash": ("name: knife", "name: a/b", SceneError, "'a/b' is not a name"),
    "contact name with a slash": ("thumb_spine:", "a/b:", SceneError, "contacts.a/b"),
    "key twice": ("name: knife", "name: a\nname: b", SceneError, "duplicate key"),
    "tab": ("tool:\n", "tool:\n\t- a\n", SceneError, "line 7: found character"),
    "bracket not closed": ("[0, 0, -9.81]", "[0, 0, -9.81", SceneError, "knife.yaml: line"),
    "python object": ("height_m: 0.0", "height_m: !!python/name:os.system ''", SceneError, "tag"),
    "date for number": ("height_m: 0.0", "height_m: 2020-01-01", SceneError, "must be a number"),
    "list for mapping": ("rest: ", "rest: [1] #", SceneError, "line"),
    "alias to itself": ("description: Lift", "description: &a [*a] #", SceneError, ""),
    "number for list": (
        "half_size_m: [0.25, 0.35]",
        "half_size_m: 3",
        SceneError,
        "table.half_size_m: must be a list like [0, 1], got 3",
    ),
    "name for mapping": (
        "to: {pitch_deg: 25, roll_deg: 0, yaw_deg: 0}",
        "to: up",
        SceneError,
        "gaits.default[0].to: must be a mapping with keys, got 'up'",
    ),
    "unknown key in the robot": (
        "  palm: palm",
        "  plam: palm",
        SceneError,
        "robot.plam: unknown key 'plam' - did you mean 'palm'?",
    ),
    "no length of a fingertip": (
        "tip_radius_m: 0.0075",
        "tip_radius_m: 0",
        SceneError,
        "robot.fingers.thumb.tip_radius_m: must be greater than 0, got 0",
    ),
    "number for a joint": (
        "couplings: [[FFJ1, FFJ2]",
        "couplings: [[FFJ1, 2]",
        SceneError,
        "robot.couplings[0][1]: must be text, got 2",
    ),
    "word for truth": ("doubling: false", "doubling: no", SceneError, "must be true or false"),
    "number for text": ("tip: tip", "tip: 3", SceneError, "tool.tip: must be text, got 3"),
    "two documents": ("table:\n", "---\ntable:\n", SceneError, "document"),
    "endless number": ("height_m: 0.0", "height_m: " + "9" * 5000, SceneError, ""),
    "huge number": ("height_m: 0.0", "height_m: 1.0e300", SceneError, "must be at most 100"),
}


@pytest.mark.parametrize(("old", "new", "kind", "fragment"), BAD.values(), ids=BAD)
def test_bad_scene(
    old: str, new: str, kind: type[InputError], fragment: str, tmp_path: Path
) -> None:
    assert old in KNIFE
    path = tmp_path / "knife.yaml"
    path.write_text(KNIFE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scene(path)
    message = str(caught.value)
    assert type(caught.value) is kind, message
    assert fragment in message
    assert caught.value.exit_code == 2
    assert caught.value.mend
    assert "\n" not in message
    assert "pydantic" not in message


def test_further_findings_are_counted() -> None:
    text = KNIFE.replace("friction: 0.8", "friction: -1")
    with pytest.raises(SceneError, match=r"and 3 more\)"):
        parse_scene(text)


@given(st.text(max_size=200))
@settings(max_examples=200, deadline=None)
def test_any_text_is_refused_with_one_line(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_scene(text)
    assert "\n" not in str(caught.value)


@given(st.integers(0, len(KNIFE) - 1), st.characters(codec="utf-8"))
@settings(max_examples=150, deadline=None)
def test_one_changed_character_never_escapes_as_another_error(place: int, character: str) -> None:
    with suppress(InputError):
        parse_scene(KNIFE[:place] + character + KNIFE[place + 1 :])
