"""``pivotgait search``: what it prints and writes, and how it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pivotgait.models import load_scene

Call = Callable[..., Any]
GOAL = ("--goal", "thumb_spine, middle_flat, index_edge_near", "--first", "thumb_spine, index_edge")


def test_a_found_sequence_is_written_as_a_scene(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "near.yaml"
    answer = call("search", "knife", *GOAL, "--no-hand", "--out", file, "--json")
    assert answer.code == 0
    data = answer.data
    assert data["found"] is True
    assert [move["kind"] for move in data["sequence"]["moves"]] == [
        "lift",
        "addition",
        "removal",
        "addition",
    ]
    assert "forces at rest" in {each["stage"] for each in data["deaths"]}
    assert file.read_text() == data["yaml"]
    scene = load_scene(file)
    assert scene.name == "near"
    assert set(scene.contacts) == set(data["sequence"]["contacts"])
    assert call("plan", file, "-o", tmp_path / "near.h5").code == 0


def test_words_and_tables_for_people(call: Call) -> None:
    answer = call("search", "knife", *GOAL, "--no-hand")
    assert answer.code == 0
    for words in ("found", "why branches died", "planned", "estimate", "fingertip"):
        assert words in answer.out


def test_nothing_found_is_an_answer_with_exit_code_1(call: Call) -> None:
    goal = ("--goal", "thumb@0.09/0, index@0.07/0", *GOAL[2:])
    answer = call("search", "knife", *goal, "--no-hand", "--time-limit", 1, "--json")
    assert answer.code == 1
    assert answer.data["found"] is False
    assert answer.data["sequence"] is None
    assert "NOT found" in call("search", "knife", *goal, "--no-hand", "--time-limit", 1).out


BAD = {
    "no goal": ["search", "knife"],
    "unknown scene": ["search", "knif", "--goal", "power-grasp"],
    "unknown contact": ["search", "knife", "--goal", "thumb_spine, index_egde"],
    "empty goal": ["search", "knife", "--goal", " "],
    "one contact": ["search", "knife", "--goal", "thumb_spine"],
    "off the handle": ["search", "knife", "--goal", "thumb_spine, index@3/0"],
    "palm below 0": ["search", "knife", "--goal", "power-grasp within -0.1 m"],
    "bad first grasp": ["search", "knife", "--goal", "power-grasp", "--first", "thumb_spine"],
    "negative seed": ["search", "knife", "--goal", "power-grasp", "--seed", "-1"],
    "no time": ["search", "knife", "--goal", "power-grasp", "--time-limit", "0"],
    "no scene's file name": ["search", "knife", "--goal", "power-grasp", "--out", "a.txt"],
    "missing folder": ["search", "knife", "--goal", "power-grasp", "--out", "no/a.yaml"],
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line(
    call: Call, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = call(*BAD[name])
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.startswith("pivotgait: error: ")
    assert answer.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_scene_whose_urdf_lies_beside_it_stays_in_its_folder(call: Call, tmp_path: Path) -> None:
    knife = load_scene("knife")
    (tmp_path / "own.urdf").write_text(knife.tool.urdf)
    text = json.loads(json.dumps(knife.yaml)).replace("urdf: chef_knife", "urdf: own.urdf")
    (tmp_path / "own.yaml").write_text(text)
    (tmp_path / "other").mkdir()
    common = ("search", tmp_path / "own.yaml", *GOAL, "--no-hand")
    refused = call(*common, "--out", tmp_path / "other" / "found.yaml")
    assert refused.code == 2
    assert "own.urdf" in refused.err
    assert call(*common, "--out", tmp_path / "found.yaml").code == 0
    assert call("plan", tmp_path / "found.yaml", "-o", tmp_path / "p.h5", "--no-hand").code == 0
