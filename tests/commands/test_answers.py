"""What the commands answer when all is well, or when a plan or a scene is not."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from pivotgait.cli import app
from pivotgait.models import builtin_scenes, export_scene
from pivotgait.plans import read_plan

Call = Callable[..., Any]
COMMANDS = [command.callback.__name__ for command in app.registered_commands if command.callback]
PHASE_KEYS = {
    "name",
    "kind",
    "finger",
    "duration_s",
    "plan_time_s",
    "min_friction_margin",
    "reorientation_deg",
}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_an_example(call: Call, command: str) -> None:
    answer = call(command, "--help")
    assert answer.code == 0
    assert f"pivotgait {command}" in answer.out.split("Example")[1]
    assert "--json" in answer.out
    assert not answer.err


def test_help_lists_every_command(call: Call) -> None:
    answer = call("--help")
    assert answer.code == 0
    assert len(COMMANDS) >= 8
    assert all(command in answer.out for command in COMMANDS)


def test_plan_prints_the_contract(call: Call, small_scene: Path, tmp_path: Path) -> None:
    path = tmp_path / "plan.h5"
    answer = call("plan", small_scene, "-o", path, "--seed", 5, "--json")
    assert answer.code == 0
    data = answer.data
    assert data["plan"] == str(path)
    assert data["valid"] is True
    assert [phase["kind"] for phase in data["phases"]] == ["lift", "addition", "removal"]
    for phase in data["phases"]:
        assert phase.keys() >= PHASE_KEYS
        assert 0.0 <= phase["min_friction_margin"] <= 1.0
    assert [phase["finger"] for phase in data["phases"]] == ["", "middle", "index"]
    certificate = data["certificate"]
    assert certificate["valid"] is True
    assert certificate["violations"] == []
    plan = read_plan(path)
    assert plan.seed == 5
    assert plan.scene == small_scene.read_text(encoding="utf-8")
    assert plan.certificate == certificate
    assert list(tmp_path.iterdir()) == [path]  # no partial file beside it


def test_certify_says_of_the_file_what_plan_said(call: Call, small_run: Path) -> None:
    answer = call("certify", small_run / "plan.h5", "--json")
    assert answer.code == 0
    assert answer.data == read_plan(small_run / "plan.h5").certificate
    assert answer.data["residuals"].keys() >= {"force_balance_n", "cone_margin_n", "ramp_n"}
    assert all(isinstance(value, float) for value in answer.data["residuals"].values())


def test_certify_finds_a_tampered_force(call: Call, small_run: Path, tmp_path: Path) -> None:
    path = tmp_path / "tampered.h5"
    path.write_bytes((small_run / "plan.h5").read_bytes())
    with h5py.File(path, "r+") as file:
        file["phases/01_addition/contacts/thumb/force"][5, 1] += 1e-3
    answer = call("certify", path, "--json")
    assert answer.code == 1
    assert answer.data["valid"] is False
    violation = next(v for v in answer.data["violations"] if v["what"] == "force_balance_n")
    assert violation["phase"] == "01_addition"
    # the rest of the balance is rounding
    assert violation["value"] == pytest.approx(1e-3, rel=1e-6)
    assert violation["limit"] == 1e-6
    table = call("certify", path)
    assert table.code == 1
    assert "NOT valid" in table.out
    assert "01_addition" in table.out


def test_certify_believes_numbers_and_no_words(call: Call, small_run: Path, tmp_path: Path) -> None:
    path = tmp_path / "boasting.h5"
    path.write_bytes((small_run / "plan.h5").read_bytes())
    with h5py.File(path, "r+") as file:
        file["phases/00_lift/tool/orientation"][3] *= 1.0 + 1e-6
        assert json.loads(file.attrs["certificate"])["valid"] is True
    assert call("certify", path).code == 1


def test_infeasible_scene_exits_1_and_leaves_no_file(
    call: Call, small_scene: Path, tmp_path: Path
) -> None:
    scene = tmp_path / "slippery.yaml"
    text = small_scene.read_text(encoding="utf-8").replace("friction: 0.8", "friction: 0.02")
    scene.write_text(text, encoding="utf-8")
    answer = call("plan", scene, "-o", tmp_path / "plan.h5", "--json")
    assert answer.code == 1
    assert not answer.out
    assert answer.err.startswith("pivotgait: error: 00_lift: ")
    assert "binds" in answer.err
    assert answer.err.count("\n") == 1
    assert call("run", scene, "--out", tmp_path / "deep" / "out").code == 1
    assert list(tmp_path.iterdir()) == [scene]


def test_tables_for_people(call: Call, small_scene: Path, tmp_path: Path) -> None:
    answer = call("plan", small_scene, "-o", tmp_path / "plan.h5")
    assert answer.code == 0
    assert "02_rem" in answer.out
    assert "certificate: valid" in answer.out
    assert not answer.err  # no terminal, no progress bar


def test_run_writes_plan_summary_and_report(small_run: Path) -> None:
    assert {"plan.h5", "summary.json", "report.html", "figures"} <= {
        path.name for path in small_run.iterdir()
    }
    assert not list(small_run.rglob("*.part"))
    page = (small_run / "report.html").read_text(encoding="utf-8")
    assert "</html>" in page
    summary = json.loads((small_run / "summary.json").read_text(encoding="utf-8"))
    assert summary["valid"] is True
    assert len(summary["phases"]) == 3


def test_report_refuses_a_broken_summary(call: Call, small_run: Path, tmp_path: Path) -> None:
    (tmp_path / "plan.h5").write_bytes((small_run / "plan.h5").read_bytes())
    (tmp_path / "summary.json").write_text('{"phases": [', encoding="utf-8")
    answer = call("report", tmp_path, "--json")
    assert answer.code == 2
    assert not answer.out
    assert "summary.json" in answer.err
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.slow  # every figure of a plan again: 9 s
def test_report_draws_the_same_folder_again(call: Call, small_run: Path, tmp_path: Path) -> None:
    (tmp_path / "plan.h5").write_bytes((small_run / "plan.h5").read_bytes())
    answer = call("report", tmp_path, "--json")
    assert answer.code == 0
    assert Path(answer.data["report"]) == tmp_path / "report.html"
    assert (tmp_path / "report.html").stat().st_size > 0


def test_scenes_lists_what_there_is(call: Call) -> None:
    answer = call("scenes", "--json")
    assert answer.code == 0
    assert [scene["name"] for scene in answer.data["scenes"]] == list(builtin_scenes())
    table = call("scenes").out
    assert all(name in table for name in builtin_scenes())


def test_schema_is_json(call: Call) -> None:
    schema = call("scenes", "--schema").data
    assert schema["properties"]["schema"]["const"] == "pivotgait-scene/1"
    assert {"tool", "table", "contacts", "gaits"} <= set(schema["required"])


@pytest.mark.parametrize("name", builtin_scenes())
def test_exported_scene_passes_the_check(call: Call, tmp_path: Path, name: str) -> None:
    text = call("scenes", "--export", name).out
    assert text == export_scene(name)
    assert call("scenes", "--export", name, "--json").data == {"name": name, "yaml": text}
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    data = call("check", path, "--json").data
    assert data["sound"] is True
    assert data["kind"] == "scene"
    assert data["name"] == name


def test_check_of_a_urdf_and_of_a_plan(call: Call, small_run: Path, tmp_path: Path) -> None:
    plan = read_plan(small_run / "plan.h5")
    urdf = tmp_path / "tool.urdf"
    urdf.write_text(plan.tool.urdf, encoding="utf-8")
    data = call("check", urdf, "--json").data
    assert (data["kind"], data["links"], data["joints"]) == ("urdf", 1, 0)
    assert data["mass_kg"] == plan.tool.mass
    data = call("check", small_run / "plan.h5", "--json").data
    assert (data["kind"], data["certificate_valid"]) == ("plan", True)
    assert data["phases"] == [phase.name for phase in plan.phases]
    assert data["duration_s"] == pytest.approx(sum(phase.duration_s for phase in plan.phases))


def test_names_that_look_like_markup_are_printed_as_they_are(
    call: Call, small_scene: Path, tmp_path: Path
) -> None:
    scene = tmp_path / "[red]odd[b].yaml"
    text = small_scene.read_text(encoding="utf-8")
    scene.write_text(text, encoding="utf-8")
    answer = call("check", scene)
    assert answer.code == 0
    assert "[red]odd[b].yaml: sound" in answer.out


def test_doctor_is_healthy(call: Call) -> None:
    answer = call("doctor", "--json")
    assert answer.code == 0
    assert answer.data["healthy"] is True
    assert set(answer.data["checks"].values()) == {"ok"}
    assert all(answer.data["packages"].values())


def test_two_plans_differ_in_nothing_but_times(
    call: Call, small_scene: Path, tmp_path: Path
) -> None:
    paths = [tmp_path / "one.h5", tmp_path / "two.h5"]
    for path in paths:
        call("plan", small_scene, "-o", path, "--json")
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_residuals_are_numbers_json_can_hold(call: Call, small_run: Path, tmp_path: Path) -> None:
    # a plan with a hole is bad input, not a certificate full of NaN
    path = tmp_path / "hole.h5"
    path.write_bytes((small_run / "plan.h5").read_bytes())
    with h5py.File(path, "r+") as file:
        file["phases/00_lift/contacts/thumb/force"][2, 0] = np.nan
    answer = call("certify", path, "--json")
    assert answer.code == 2
    assert not answer.out
    assert "thumb" in answer.err
