"""``pivotgait feasibility --map``: what it prints and writes, and what it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Call = Callable[..., Any]
FRICTION, MASS = "contacts.*.friction=0.2:1.2", "tool.mass_scale=0.2:5"
COARSE = ("--phase", "00_lift", "--tolerance", "0.125")


def test_a_map_is_printed_and_written(call: Call, tmp_path: Path) -> None:
    given = ("feasibility", "knife", "--map", FRICTION, "--map", MASS, *COARSE, "--out", tmp_path)
    answer = call(*given)
    assert answer.code == 0
    assert "feasible area" in answer.out
    assert {each.name for each in tmp_path.iterdir()} == {"map.json", "map.pdf", "map.png"}
    found = json.loads((tmp_path / "map.json").read_text())["maps"][0]
    assert len(found["points"]) == len(found["value"]) == found["evaluated"]
    data = call(*given, "--json").data
    assert data["maps"][0] == found


def test_slices_and_shares(call: Call) -> None:
    given = ("feasibility", "knife", "--map", FRICTION, "--map", MASS, *COARSE, "--json")
    maps = call(*given, "--map", "tool.pitch_deg=20:40").data["maps"]
    assert [each["fixed"]["tool.pitch_deg"] for each in maps] == [20.0, 30.0, 40.0]
    share = call(*given, "--spread", "contacts.*.friction=0.1", "--draws", 1).data["share"]
    assert share["draws"] == 1
    assert {each for row in share["share"] for each in row} <= {0.0, 1.0}


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--map", FRICTION], "one parameter"),
        (["--map", "friction", "--map", MASS], "PATH=LO:HI"),
        (["--map", "table.friction=1:0.5", "--map", MASS], "smaller value first"),
        (["--map", FRICTION, "--map", MASS, "--map", "a=1:2", "--map", "b=1:2"], "three at most"),
        (["--map", FRICTION, "--map", MASS, "--map", "removed=toe"], "thumb"),
        (["--map", FRICTION, "--map", MASS, "--phase", "lift"], "00_lift"),
        (["--map", FRICTION, "--map", MASS, "--quantity", "luck"], "margin"),
        (["--map", FRICTION, "--map", MASS, "--spread", "table.friction=wide"], "PATH=SD"),
        (["--map", FRICTION, "--map", MASS, "--set", "table.friction"], "--set"),
    ],
)
def test_nonsense_is_refused_in_one_line(call: Call, more: list[str], words: str) -> None:
    answer = call("feasibility", "knife", *more)
    assert answer.code == 2
    assert words in answer.err
    assert answer.err.count("\n") == 1
