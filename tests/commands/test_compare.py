"""``compare``: what it writes, prints and answers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pivotgait.gaits import plan_gait
from pivotgait.models import export_scene, parse_scene
from pivotgait.plans import write_plan
from pivotgait.validation import CompareOptions, RunOptions

Call = Callable[..., Any]
LEFT = {
    "comparison.json",
    "comparison_pybullet.h5",
    "comparison_mujoco.h5",
    "figures/comparison.pdf",
    "figures/comparison.png",
}


@pytest.fixture(scope="module")
def lift(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Plan file of a gait that is the knife's lift alone."""
    whole = export_scene("knife").splitlines(keepends=True)
    end = next(k for k, line in enumerate(whole) if "kind: lift" in line)
    plan = plan_gait(parse_scene("".join(whole[: end + 1])))
    path = tmp_path_factory.mktemp("lift") / "plan.h5"
    write_plan(plan, path)
    return path


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """A short grasp and hold."""

    def options(**given: Any) -> CompareOptions:
        return CompareOptions(**{**given, "run": RunOptions(grasp_s=0.3, hold_s=0.05)})

    monkeypatch.setattr("pivotgait.validation.CompareOptions", options)


@pytest.mark.usefixtures("short")
def test_a_lift_in_both_engines(call: Call, lift: Path, tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    out = tmp_path / "new" / "out"
    answer = call("compare", lift, "-o", out, "--no-causes", "--json")
    assert answer.code == 0
    assert answer.err == ""
    left = {each.relative_to(out).as_posix() for each in out.rglob("*") if each.is_file()}
    assert left == LEFT
    told = json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert answer.data == {**told, "out": str(out)}
    nominal = told["nominal"]
    assert nominal["same_verdict"]
    assert [each["name"] for each in nominal["phases"]] == ["00_lift", "final_hold"]
    assert nominal["agrees"], nominal["largest_gap"]
    # two engines, not one twice
    assert nominal["phases"][0]["position_mm"] > 1e-4
    assert nominal["share_within"] > 0.9
    assert told["causes"] is None
    assert told["trials"] is None


@pytest.mark.usefixtures("short")
@pytest.mark.slow  # eight runs more, and four trials
def test_causes_and_trials_are_shown(call: Call, lift: Path) -> None:
    pytest.importorskip("mujoco")
    answer = call("compare", lift, "--causes", "--trials", 2)
    assert "step halved" in answer.out
    assert "likely cause" in answer.out
    assert "the same seeds in both engines" in answer.out
    assert "Cohen's kappa" in answer.out
    assert "outcomes crossed" in answer.out


def test_without_mujoco_it_says_how_to_install_it(
    call: Call, lift: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "pivotgait.validation.engine_check.find_spec",
        lambda name: None if name == "mujoco" else name,
    )
    answer = call("compare", lift, "-o", tmp_path / "out")
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.count("\n") == 1
    assert "mujoco is not installed - pip install 'pivotgait[mujoco]'" in answer.err
    assert not (tmp_path / "out").exists()


def test_a_plan_without_a_robot_is_bad_input(call: Call, small_run: Path) -> None:
    answer = call("compare", small_run / "plan.h5")
    assert answer.code == 2
    assert answer.err.count("\n") == 1


@pytest.mark.parametrize("options", [("--trials", "-1"), ("--controller", "none"), ("-o",)])
def test_bad_options_are_bad_input(call: Call, lift: Path, options: tuple[str, ...]) -> None:
    answer = call("compare", lift, *options)
    assert answer.code == 2
    assert answer.err.count("\n") == 1


def test_a_folder_that_cannot_be_made_is_bad_input(call: Call, lift: Path) -> None:
    answer = call("compare", lift, "-o", lift / "below")
    assert answer.code == 2
    assert "cannot be made" in answer.err
