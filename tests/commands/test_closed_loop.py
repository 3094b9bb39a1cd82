"""``run`` carries its plan out: what it writes, prints and answers."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from pivotgait.models import export_scene
from pivotgait.plans import GaitPlan
from pivotgait.reporting import Report
from pivotgait.validation import Stage, TrialOptions, TrialResult, TrialSet, Verdict

Call = Callable[..., Any]
LEFT = {"plan.h5", "summary.json", "record.h5", "trials.h5", "report.html"}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The knife's lift, with few steps."""
    text = export_scene("knife")
    text = text[: text.index("    - {kind: relocation")]
    assert "steps: 75" in text
    path = tmp_path_factory.mktemp("scene") / "begin.yaml"
    path.write_text(text.replace("steps: 75", "steps: 30"), encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def cheap_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """No drawing: the page has its own tests."""

    def page(folder: Path) -> Report:
        (folder / "report.html").write_text("", encoding="utf-8")
        return Report(folder / "report.html", folder / "report.pdf")

    monkeypatch.setattr("pivotgait.reporting.report_from_folder", page)


@pytest.fixture
def simulated(monkeypatch: pytest.MonkeyPatch) -> Callable[[bool], list[dict[str, Any]]]:
    """Replace the simulator by one in which nominal runs pass or not; perturbed ones fail."""

    def install(passes: bool) -> list[dict[str, Any]]:
        asked: list[dict[str, Any]] = []

        def run_trials(
            plan: GaitPlan, seeds: Sequence[int], options: TrialOptions, **given: Any
        ) -> TrialSet:
            asked.append({"seeds": list(seeds), "perturbed": options.perturbed, **given})
            good = passes and not options.perturbed
            verdict = Verdict(True) if good else Verdict(False, "slip", "00_lift", 0.5, "tip [b]")
            results = tuple(TrialResult(seed, verdict) for seed in seeds)
            stage = Stage("00_lift", len(seeds), len(seeds) * good)
            return TrialSet(options, (stage,), results)

        monkeypatch.setattr("pivotgait.commands.reporting.run_trials", run_trials)
        return asked

    return install


@pytest.mark.parametrize(("passes", "code"), [(True, 0), (False, 1)])
def test_the_nominal_run_decides_the_exit_code(
    call: Call, scene: Path, tmp_path: Path, simulated: Any, passes: bool, code: int
) -> None:
    asked = simulated(passes)
    answer = call("run", scene, "--out", tmp_path, "--no-view", "--seed", 4, "--trials", 3,
                  "--json")  # fmt: skip
    assert answer.code == code
    assert [(each["seeds"], each["perturbed"]) for each in asked] == [
        ([4], False),
        ([4, 5, 6], True),
    ]
    assert {each["folder"] for each in asked} == {scene.parent}
    assert {path.name for path in tmp_path.iterdir()} == LEFT
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    files = {"report": str(tmp_path / "report.html"), "pdf": str(tmp_path / "report.pdf")}
    assert answer.data == {**summary, **files}
    assert summary["valid"] is True
    assert summary["validation"]["passed"] == int(passes)
    assert (summary["trials"]["trials"], summary["trials"]["passed"]) == (3, 0)


def test_the_stages_are_printed(call: Call, scene: Path, tmp_path: Path, simulated: Any) -> None:
    simulated(False)
    answer = call("run", scene, "--out", tmp_path, "--no-view")
    assert answer.code == 1
    assert "hybrid control in pybullet, nominal" in answer.out
    assert "tip [b]" in answer.out
    assert not (tmp_path / "trials.h5").exists()


def test_without_validation_nothing_runs_and_old_records_go(
    call: Call, scene: Path, tmp_path: Path, simulated: Any
) -> None:
    asked = simulated(True)
    for name in ("record.h5", "trials.h5", "run_view.html", "view.html"):
        (tmp_path / name).write_bytes(b"of another plan")
    answer = call("run", scene, "--out", tmp_path, "--no-view", "--no-validate", "--json")
    assert answer.code == 0
    assert not asked
    assert {path.name for path in tmp_path.iterdir()} == {"plan.h5", "summary.json", "report.html"}
    assert "validation" not in answer.data


def test_a_scene_without_a_robot_is_not_carried_out(
    call: Call, small_scene: Path, tmp_path: Path, simulated: Any
) -> None:
    asked = simulated(True)
    assert call("run", small_scene, "--out", tmp_path, "--no-view").code == 0
    assert not asked


@pytest.mark.parametrize(
    "options",
    [
        ("--no-hand", "--validate"),
        ("--no-hand", "--trials", "2"),
        ("--no-validate", "--trials", "2"),
        ("--trials", "-1"),
    ],
)
def test_contradictions_are_bad_input(call: Call, tmp_path: Path, options: tuple[str, ...]) -> None:
    answer = call("run", "knife", "--out", tmp_path / "out", *options)
    assert answer.code == 2
    assert not answer.out
    assert answer.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("options", [("--validate",), ("--trials", "2")])
def test_what_has_no_robot_cannot_be_carried_out(
    call: Call, small_scene: Path, tmp_path: Path, options: tuple[str, ...]
) -> None:
    answer = call("run", small_scene, "--out", tmp_path, "--no-view", *options)
    assert answer.code == 2
    assert "no motion of a robot" in answer.err
    assert answer.err.count("\n") == 1


@pytest.mark.slow  # a simulated run and two recorded scenes
def test_a_lift_in_pybullet(call: Call, scene: Path, tmp_path: Path) -> None:
    answer = call("run", scene, "--out", tmp_path, "--json")
    assert answer.code == 0, answer.data["validation"]["runs"]
    assert answer.data["validation"]["simulator"] == "pybullet"
    there = {path.name for path in tmp_path.iterdir()}
    assert there == (LEFT - {"trials.h5"}) | {"view.html", "run_view.html"}


@pytest.mark.slow  # two simulated runs
def test_a_guarded_run_out_of_danger_is_the_same(call: Call, scene: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.h5"
    assert call("plan", scene, "-o", plan).code == 0
    plain = call("validate", plan, "--json")
    guarded = call("validate", plan, "--recover", "--json")
    assert (plain.code, guarded.code) == (0, 0)
    (one,), (other,) = plain.data["runs"], guarded.data["runs"]
    assert other["metrics"] == one["metrics"]
    assert guarded.data["stages"] == plain.data["stages"]
