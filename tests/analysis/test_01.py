"""Laws of study 01: what a removal without and with pivoting can and cannot do."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.analysis.studies import load_study

SOLVER_DEG = 1e-2
"""Static bounds come from a local solver with tolerances of 1e-9; this is ample."""
PLANNED_DEG = 0.5
"""Planned turns trade a few tenths of a degree for better aligned forces (up to 0.4 seen)."""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("study_01")


@pytest.fixture(scope="module")
def result(out: Path) -> dict[str, Any]:
    return load_study("01").main(quick=True, out=out)


@pytest.fixture(scope="module")
def cells(result: dict[str, Any]) -> list[dict[str, Any]]:
    return [cell for each in result["sweeps"].values() for row in each["cells"] for cell in row]


def grid(result: dict[str, Any], sweep: str, name: str) -> np.ndarray:
    """(friction, place) of one number."""
    return np.array([[c[name] for c in row] for row in result["sweeps"][sweep]["cells"]], float)


@pytest.mark.parametrize("sweep", ["along", "around", "nominal"])
def test_more_friction_never_needs_more(result, sweep):
    least, needed = grid(result, sweep, "least_N"), grid(result, sweep, "needed_deg")
    planned = grid(result, sweep, "planned_deg")
    assert np.isfinite(needed).all()
    assert np.all(np.diff(least, axis=0) <= 1e-6)
    assert np.all(np.diff(needed, axis=0) <= SOLVER_DEG)
    steps = np.diff(planned, axis=0)
    assert np.all(steps[np.isfinite(steps)] <= PLANNED_DEG)


def test_no_removal_turns_less_than_the_static_bound(cells):
    planned = [cell for cell in cells if cell["outcome"] in ("planned", "detour")]
    assert planned
    for cell in planned:
        assert cell["needed_deg"] <= cell["planned_deg"] + 0.05


def test_turning_is_needed_exactly_where_the_finger_cannot_leave_at_rest(cells):
    for cell in cells:
        assert (cell["least_N"] == 0.0) == (cell["needed_deg"] == 0.0)
    assert {cell["least_N"] == 0.0 for cell in cells} == {True, False}


def test_forces_at_rest_end_at_the_least_force_and_no_smaller_turn_holds(cells):
    assert all(cell["bracketed"] for cell in cells)
    assert not any(cell["nearer_found"] for cell in cells)


def test_every_cell_has_an_outcome_and_most_are_planned(result, cells):
    assert {cell["outcome"] for cell in cells} <= set(load_study("01").OUTCOMES)
    assert all(cell["message"] for cell in cells if cell["outcome"] not in ("planned", "detour"))
    assert sum(cell["outcome"] == "planned" for cell in cells) >= 0.8 * len(cells)
    assert sum(result["findings"]["outcomes"].values()) == result["findings"]["cells"]


def test_files_are_written_and_the_numbers_read_back(result, out):
    assert sorted(path.name for path in out.iterdir()) == [
        "removal_knife.json",
        "removal_knife.pdf",
        "removal_knife.png",
    ]
    assert all(path.stat().st_size > 1000 for path in out.iterdir())
    read = json.loads((out / "removal_knife.json").read_text())
    assert read["sweeps"]["along"] == result["sweeps"]["along"]


def test_a_place_off_the_handle_is_an_outcome_not_a_crash():
    study = load_study("01")
    situation = study.Situation.of(study.load_scene("knife"))
    cell = study.solve_cell(situation, 0.6, 0.5, 270.0)
    assert cell.outcome == "no place"
    assert "off the handle" in cell.message
