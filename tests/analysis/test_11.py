"""Study 11 in short: every step and stiffness has a row, and none decides of the lift."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "analysis" / "11_step_and_stiffness.py"


@pytest.mark.slow
def test_the_lift_passes_at_every_step_and_stiffness(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("study_11", STUDY)
    assert spec is not None
    assert spec.loader is not None
    study = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(study)
    result = study.main(quick=True, out=tmp_path)
    cells = {(row["step_s"], row["stiffness_N_m"]) for row in result["runs"]}
    assert len(cells) == len(result["runs"]) == 2 * len(study.STIFFNESS_N_M)
    failed = [row for row in result["runs"] if not row["passed"]]
    assert not [row for row in failed if row["step_s"] <= 1e-3], failed
    assert result["all_passed"] == (not failed)
    (path,) = tmp_path.iterdir()
    assert json.loads(path.read_text()) == result
