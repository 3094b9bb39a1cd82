"""``pivotgait feasibility``: exit codes, JSON, words, and how long it takes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

Call = Callable[..., Any]


def test_a_feasible_gait_is_told_so(call: Call) -> None:
    answer = call("feasibility", "knife")
    assert answer.code == 0
    assert "knife: feasible" in answer.out
    assert "03_removal" in answer.out
    assert "wrench, at end" in answer.out


def test_json_of_an_infeasible_one(call: Call) -> None:
    answer = call("feasibility", "knife", "--turn-max", 0, "--json")
    assert answer.code == 1
    data = answer.data
    assert data["feasible"] is False
    assert data["binding"]["kind"] == "turn"
    assert data["binding"]["phase"] == "03_removal"
    assert data["mends"][0]["change"] == "turn_max_deg"
    enough = data["mends"][0]["to"]
    assert call("feasibility", "knife", "--turn-max", enough, "--json").code == 0
    assert call("feasibility", "knife", "--turn-max", enough - 0.1, "--json").code == 1


def test_the_mend_is_printed_so_that_it_can_be_pasted(call: Call) -> None:
    answer = call("feasibility", "knife", "--set", "table.normal_force_N.min=1.5", "--mends", 1)
    assert answer.code == 1
    change = answer.out.split("--set '")[1].split("'")[0]
    assert call("feasibility", "knife", "--set", change).code == 0


def test_without_mends_none_are_sought(call: Call) -> None:
    answer = call("feasibility", "knife", "--set", "tool.mass_scale=4", "--mends", 0, "--json")
    assert answer.code == 1
    assert answer.data["mends"] == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nosuch",), "unknown scene"),
        (("knife", "--set", "friction"), "PATH=VALUE"),
        (("knife", "--set", "=3"), "PATH=VALUE"),
        (("knife", "--set", "table.fricton=3"), "table.fricton"),
        (("knife", "--set", "table.friction=-1"), "greater than 0"),
        (("knife", "--turn-max", "-5"), "deg"),
        (("knife", "--gait", "dance"), "unknown gait"),
    ],
)
def test_bad_input_is_one_line(call: Call, arguments: tuple[str, ...], words: str) -> None:
    answer = call("feasibility", *arguments)
    assert answer.code == 2
    assert words in answer.err
    assert answer.err.count("\n") == 1
    assert not answer.out


LIBRARIES = (
    "import casadi, clarabel, numpy, pinocchio, pydantic, rich.table, scipy.interpolate, "
    "scipy.spatial.transform, typer"
)
TIMES_THE_LIBRARIES = 5.0
"""Loading them takes half a second where a verdict takes 1.8 s, and both grow alike on a slower
machine: 3.5 times where nothing else runs, and two fifths more for what else may."""


def test_it_takes_a_few_times_as_long_as_loading_its_libraries() -> None:
    command = "from pivotgait.cli import main; main(['feasibility', 'knife', '--json'])"
    spent = [(processor_time(LIBRARIES), processor_time(command)) for _ in range(3)]
    libraries, ours = (min(each) for each in zip(*spent, strict=True))
    assert ours < TIMES_THE_LIBRARIES * libraries


def processor_time(code: str) -> float:
    """Of a fresh process in one thread [s]."""
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    before = os.times()
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env=one_thread)
    after = os.times()
    return sum(after[2:4]) - sum(before[2:4])
