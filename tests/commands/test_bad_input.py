"""Bad input: exit code 2, one line on stderr that says what, nothing else anywhere."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pivotgait.models import export_scene

Call = Callable[..., Any]
KNIFE = export_scene("knife")
SCENES = {
    "no_yaml": "a: [1, 2",
    "empty": "",
    "list": "- knife\n",
    "unknown_field": KNIFE + "colour: red\n",
    "twice": KNIFE + "name: again\n",
    "no_number": KNIFE.replace("friction: 0.4", "friction: slippery"),
    "nan": KNIFE.replace("friction: 0.4", "friction: .nan"),
    "negative": KNIFE.replace("friction: 0.4", "friction: -0.4"),
    "bounds": re.sub(r"min: [\d.]+, max: 6.0", "min: 7, max: 6.0", KNIFE),
    "no_tool": KNIFE.replace("urdf: chef_knife", "urdf: chef_knive"),
    "outside": KNIFE.replace("urdf: chef_knife", "urdf: ../../../tool.urdf"),
    "off_handle": re.sub(r"(middle_flat:.*along_m: )[\d.]+", r"\g<1>9.0", KNIFE),
    "no_contact": KNIFE.replace("contact: middle_flat", "contact: middle_falt"),
    "too_low": KNIFE.replace("pitch_deg: 25", "pitch_deg: 1"),
    "schema": KNIFE.replace("pivotgait-scene/1", "pivotgait-scene/9"),
    "steps": KNIFE.replace("steps: 75", "steps: 0"),
}
"""Name of a scene file -> its text, each wrong in one way."""
FILES: dict[str, bytes] = {
    "latin.yaml": KNIFE.replace("chef's", "Köchin's").encode("latin-1"),
    "text.h5": b"this is no HDF5 file\n",
    "empty.h5": b"",
    "broken.urdf": b"<robot name='a'><link name='b'></robot>",
    "weightless.urdf": b'<robot name="a" version="1.1"><link name="b"><inertial><mass value="-1"/>'
    b'<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>',
    "picture.png": b"\x89PNG",
    "nosuffix": b"?",
}

CALLS: dict[str, list[str]] = {
    **{f"scene {name}": ["plan", f"{name}.yaml", "-o", "new.h5"] for name in SCENES},
    "unknown scene": ["plan", "knif", "-o", "new.h5"],
    "missing scene file": ["plan", "missing.yaml", "-o", "new.h5"],
    "scene is a folder": ["plan", "folder.yaml", "-o", "new.h5"],
    "scene is not UTF-8": ["plan", "latin.yaml", "-o", "new.h5"],
    "scene with a null byte": ["plan", "a\0b.yaml", "-o", "new.h5"],
    "unknown gait": ["plan", "knife", "-o", "new.h5", "--gait", "slow"],
    "negative seed": ["plan", "knife", "-o", "new.h5", "--seed", "-1"],
    "seed no number": ["plan", "knife", "-o", "new.h5", "--seed", "one"],
    "seed beyond 64 bits": ["plan", "knife", "-o", "new.h5", "--seed", str(2**70)],
    "output in a missing folder": ["plan", "knife", "-o", "missing/new.h5"],
    "output is a folder": ["plan", "knife", "-o", "folder.yaml"],
    "output is empty": ["plan", "knife", "-o", ""],
    "output with a null byte": ["plan", "knife", "-o", "a\0b.h5"],
    "output's name is too long": ["plan", "knife", "-o", 300 * "x" + ".h5"],
    "scene's name is too long": ["plan", 300 * "x" + ".yaml", "-o", "new.h5"],
    "plan's name is too long": ["certify", 300 * "x" + ".h5"],
    "file's name is too long": ["check", 300 * "x" + ".urdf"],
    "folder's name is too long": ["report", 300 * "x"],
    "out's name is too long": ["run", "knife", "--out", 300 * "x"],
    "out with a null byte": ["run", "knife", "--out", "a\0b"],
    "no scene": ["plan"],
    "unknown option": ["plan", "knife", "--quickly"],
    "unknown command": ["plam", "knife"],
    "run into a file": ["run", "knife", "--out", "text.h5"],
    "run below a file": ["run", "knife", "--out", "text.h5/out"],
    "run of an unknown scene": ["run", "knif", "--out", "new/out"],
    "run with an unknown gait": ["run", "knife", "--out", "new/out", "--gait", "slow"],
    "run without out": ["run", "knife"],
    "certify nothing": ["certify", "missing.h5"],
    "certify a folder": ["certify", "folder.yaml"],
    "certify text": ["certify", "text.h5"],
    "certify an empty file": ["certify", "empty.h5"],
    "certify a null byte": ["certify", "a\0b.h5"],
    "report on nothing": ["report", "missing"],
    "report on a folder without a plan": ["report", "folder.yaml"],
    "export of an unknown scene": ["scenes", "--export", "knif"],
    "schema and export": ["scenes", "--schema", "--export", "knife"],
    "check nothing": ["check", "missing.urdf"],
    "check a null byte": ["check", "a\0b.urdf"],
    "check a picture": ["check", "picture.png"],
    "check no suffix": ["check", "nosuffix"],
    "check a broken URDF": ["check", "broken.urdf"],
    "check a weightless URDF": ["check", "weightless.urdf"],
    "check text as a plan": ["check", "text.h5"],
    "check a wrong scene": ["check", "unknown_field.yaml"],
    "check a folder": ["check", "folder.yaml"],
}


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder full of bad files, as the working directory."""
    for name, text in SCENES.items():
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder.yaml").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def content(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize("flags", [[], ["--json"]], ids=["plain", "json"])
@pytest.mark.parametrize("arguments", CALLS.values(), ids=CALLS.keys())
def test_bad_input(call: Call, desk: Path, arguments: list[str], flags: list[str]) -> None:
    before = content(desk)
    answer = call(*arguments, *flags)
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.startswith("pivotgait: error: ")
    assert answer.err.endswith("\n")
    assert answer.err.count("\n") == 1
    assert "Traceback" not in answer.err
    assert len(answer.err) > len("pivotgait: error: \n") + 10  # it says something
    assert content(desk) == before


def test_every_wrong_scene_is_wrong_in_the_way_it_says() -> None:
    assert all(text != KNIFE for text in SCENES.values())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["plan", "knif"], ["knif", "did you mean 'knife'", "screwdriver"]),
        (["plan", "unknown_field.yaml"], ["unknown_field.yaml", "colour"]),
        (["plan", "negative.yaml"], ["negative.yaml", "table.friction"]),
        (["plan", "no_contact.yaml"], ["middle_falt", "did you mean 'middle_flat'", "gaits"]),
        (["plan", "off_handle.yaml"], ["contacts.middle_flat", "along_m", "choose it within"]),
        (["plan", "too_low.yaml"], ["mm", "raise pitch_deg"]),
        (["plan", "knife", "-o", "missing/new.h5"], ["missing/new.h5", "does not exist"]),
        (["certify", "text.h5"], ["text.h5"]),
        (["check", "picture.png"], ["picture.png", ".urdf", ".yaml", ".h5"]),
        (["plam"], ["plam", "--help"]),
    ],
)
def test_the_line_says_what_and_where_and_how_to_mend(
    call: Call, desk: Path, arguments: list[str], words: list[str]
) -> None:
    line = call(*arguments).err
    assert [word for word in words if word not in line] == []


def test_debug_shows_the_traceback_and_the_same_line_and_code(call: Call, desk: Path) -> None:
    quiet, loud = call("certify", "missing.h5"), call("certify", "missing.h5", "--debug")
    assert loud.code == quiet.code == 2
    assert loud.err.startswith("Traceback")
    assert loud.err.endswith(quiet.err)
    assert loud.out == ""
