"""Study 14 in short: outcomes with and without recovery add up, and the files are written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.analysis.studies import load_study


@pytest.mark.slow
def test_recovery_in_short(tmp_path: Path) -> None:
    study = load_study("14")
    result = study.main(quick=True, out=tmp_path, seed=2005, workers=1)
    (found,) = result["conditions"].values()
    for way in study.WAYS:
        assert sum(found[way]["classes"].values()) == result["trials"] == 1
        assert found[way]["classes"].get("passed", 0) == found[way]["passed"]
        if way != "without":
            gained = found[way]["passed"] - found["without"]["passed"]
            assert gained == found[way]["saved"] - found[way]["spoilt"]
            assert sum(found[way]["measures"].values()) == len(found[way]["runs"][0]["recovery"])
    assert "recovery" not in found["without"]["runs"][0]
    assert json.loads((tmp_path / "recovery_knife.json").read_text()) == result
    assert (tmp_path / "recovery_knife.pdf").is_file()
