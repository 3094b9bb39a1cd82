"""Laws of study 02: what force control and pivoting are worth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.analysis.studies import load_study


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study_02")


@pytest.fixture(scope="module")
def result(out: Path) -> dict[str, Any]:
    return load_study("02").main(quick=True, out=out)


@pytest.mark.slow
def test_force_control_presses_closer_to_the_plan(result: dict[str, Any]) -> None:
    cells = {(cell["way"], cell["width_m"]): cell for cell in result["cells"]}
    for width in load_study("02").SHOWN_WIDTH_M:
        ours, theirs = cells["hybrid", width], cells["position", width]
        assert not ours["failure"]
        for name in ("holding_force_rms_N", "loading_force_rms_N"):
            assert 2.0 * ours["metrics"][name] < theirs["metrics"][name]


@pytest.mark.slow
def test_a_removal_without_pivoting_needs_more_friction(result: dict[str, Any]) -> None:
    shares = result["friction_share"]
    assert shares["pivoting"] <= shares["usable"] + 1e-6 < shares["without"]


@pytest.mark.slow
def test_files_are_written_and_the_numbers_read_back(result: dict[str, Any], out: Path) -> None:
    assert sorted(path.name for path in out.iterdir()) == [
        "control.json",
        "control_added_finger.pdf",
        "control_added_finger.png",
        "control_outcomes.pdf",
        "control_outcomes.png",
    ]
    assert json.loads((out / "control.json").read_text())["cells"] == result["cells"]
    assert sum(each["runs"] for each in result["summary"].values()) == len(result["cells"])
