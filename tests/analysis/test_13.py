"""Study 13: gaits end where a loaded finger begins to hold; every run has its line."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from pivotgait.plotting.walk_drift import Walk, walk_drift
from tests.analysis.studies import load_study


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return load_study("13")


def test_a_gait_ends_where_a_loaded_finger_holds_and_not_where_one_leaves(
    study: ModuleType,
) -> None:
    loads = np.array([[0, 1], [0, 1], [0, 0], [1, 0], [0, 0], [1, 0], [0, 0]], dtype=float)
    holds = np.array([[1, 0], [1, 0], [1, 1], [0, 1], [0, 1], [0, 1], [1, 1]], dtype=float)
    ends = study.addition_ends(SimpleNamespace(loads=loads, holds=holds))
    assert ends.tolist() == [2, 6]


def test_every_run_has_a_line_in_each_panel_and_every_way_one_name() -> None:
    def walk(way: str, perturbed: bool, count: int) -> Walk:
        return Walk(way, perturbed, *(np.arange(float(count)),) * 3)

    walks = [walk("a", False, 7), walk("b", False, 7), walk("b", True, 3), walk("a", True, 0)]
    figure = walk_drift(walks)
    for axes in figure.axes:
        assert sorted(len(line.get_xdata()) for line in axes.lines) == [0, 3, 7, 7]
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert sorted(names) == ["a", "b"]


@pytest.mark.slow
def test_a_quick_walk_is_run_both_ways_and_written(study: ModuleType, tmp_path: Path) -> None:
    result = study.main(quick=True, out=tmp_path)
    assert [run["replans"] for run in result["runs"]] == [False, True]
    for run in result["runs"]:
        assert run["passed"], run
        assert len(run["tip_mm"]) == len(run["finger_mm"]) == result["gaits"] + 1
        assert len(run["seams"]) == (result["gaits"] if run["replans"] else 0)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["walking.json", "walking.pdf", "walking.png"]
    assert json.loads((tmp_path / "walking.json").read_text())["runs"] == result["runs"]
