"""Study 11 in short: every step and stiffness has a row, and none decides of the lift."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.analysis.studies import load_study


@pytest.mark.slow
def test_the_lift_passes_at_every_step_and_stiffness(tmp_path: Path) -> None:
    study = load_study("11")
    result = study.main(quick=True, out=tmp_path)
    cells = {(row["step_s"], row["stiffness_N_m"]) for row in result["runs"]}
    assert len(cells) == len(result["runs"]) == 2 * len(study.STIFFNESS_N_M)
    failed = [row for row in result["runs"] if not row["passed"]]
    assert not [row for row in failed if row["step_s"] <= 1e-3], failed
    assert result["all_passed"] == (not failed)
    (path,) = tmp_path.iterdir()
    assert json.loads(path.read_text()) == result
