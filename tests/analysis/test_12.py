"""Study 12: its random goals can be held, and every search is counted."""

from __future__ import annotations

import importlib.util
import json
import sys
from collections import Counter
from itertools import islice
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from pivotgait.gait_search import Deaths
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.models import load_scene

STUDY = Path(__file__).parents[2] / "analysis" / "12_gait_search.py"


@pytest.fixture(scope="module")
def study() -> ModuleType:
    sys.path.insert(0, str(STUDY.parent))
    try:
        spec = importlib.util.spec_from_file_location("study_12", STUDY)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[spec.name] = module
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(STUDY.parent))
    return module


def test_goals_drawn_can_be_held_and_the_others_are_counted(study: ModuleType) -> None:
    draws = study.Draws(load_scene("knife"), np.random.default_rng(20))
    goals = list(islice(draws, 1))
    assert draws.counts["kept"] == len(goals)
    assert draws.counts.total() > len(goals)
    for goal in goals:
        contacts = [each.contact for each in goal.contacts.values()]
        assert {each.finger for each in contacts} == {"thumb", "index", "middle"}
        assert grasp_depths(draws.scene, [contacts], draws.lifted)[0] >= 0.0
        assert study.read_goal(goal.text, draws.scene).contacts.keys() == goal.contacts.keys()


def test_the_same_seed_draws_the_same_goals(study: ModuleType) -> None:
    def first() -> tuple[str, Counter[str]]:
        draws = study.Draws(load_scene("knife"), np.random.default_rng(20))
        return next(iter(draws)).text, draws.counts

    assert first() == first()


def test_the_reason_is_the_dearest_tests_most_frequent_one(study: ModuleType) -> None:
    deaths = Deaths()
    deaths.add("forces at rest", "lift", 900)
    deaths.add("postures", "reach at a lift", 3)
    deaths.add("postures", "collision at a lift", 5)
    result = SimpleNamespace(ended="time", deaths=deaths)
    assert study.reason(result) == "time; postures: collision at a lift"


def test_every_run_is_counted(study: ModuleType) -> None:
    runs = [
        {"solved": k % 3 > 0, "elapsed_s": float(k), "reason": "time" if k % 3 == 0 else ""}
        for k in range(10)
    ]
    total = study.summary(runs)
    assert total["goals"] == total["solved"] + sum(total["failures"].values()) == 10
    assert total["wilson_95"][0] < total["solved"] / total["goals"] < total["wilson_95"][1]


@pytest.mark.slow
def test_a_quick_study_counts_everything_and_writes_its_files(
    study: ModuleType, tmp_path: Path
) -> None:
    result = study.main(quick=True, out=tmp_path)
    assert result["named"]["knife"]["solved"]
    assert len(result["random"]["runs"]) == study.QUICK_GOALS
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["gait_search.json", "gait_search.pdf", "gait_search.png"]
    written = json.loads((tmp_path / "gait_search.json").read_text())
    assert set(written) == set(result)
