"""``plan`` with the arm-hand and without it, of a scene that has a robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import pytest

from pivotgait.commands.output import Output
from pivotgait.commands.planning import Planned, make_plan, show_phases
from pivotgait.models import export_scene
from pivotgait.plans import read_plan

Call = Callable[..., Any]


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The knife's scene up to its first addition, with fewer steps."""
    text = export_scene("knife")
    text = text[: text.index("    - {kind: removal")]
    for old, new in (("steps: 75", "steps: 30"), ("steps: 40", "steps: 10")):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path_factory.mktemp("scene") / "begin.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def planned(scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Planned:
    """Plan of the scene's robot, made by the command's function."""
    path = tmp_path_factory.mktemp("plan") / "hand.h5"
    return make_plan(str(scene), path, 0, None, Output(json_output=True))


def test_the_hand_is_planned_unless_told(planned: Planned) -> None:
    data = planned.summary
    assert data["valid"] is True, data["certificate"]["violations"]
    assert [phase["kind"] for phase in data["phases"]] == ["lift", "relocation", "addition"]
    assert data["postures"].keys() == {"starts", "search_time_s"}
    assert data["postures"]["starts"] >= 1
    assert {"torque", "speed", "range"} == data["joints"].keys()
    spent = sum(phase["plan_time_s"] for phase in data["phases"])
    # every term counted once; sums of floats in another order
    total = spent + data["postures"]["search_time_s"]
    assert data["plan_time_s"] == pytest.approx(total, rel=1e-12)
    durations = sum(phase.duration_s for phase in planned.plan.phases)
    assert data["motion_time_s"] == pytest.approx(durations, rel=1e-12)
    assert read_plan(Path(data["plan"])).robot is not None


def test_without_the_hand_only_what_the_tool_feels(call: Call, scene: Path, tmp_path: Path) -> None:
    answer = call("plan", scene, "-o", tmp_path / "plan.h5", "--no-hand", "--json")
    assert answer.code == 0
    data = answer.data
    assert data["valid"] is True
    assert [phase["kind"] for phase in data["phases"]] == ["lift", "addition"]
    assert data.keys().isdisjoint({"postures", "joints"})
    spent = sum(phase["plan_time_s"] for phase in data["phases"])
    assert data["plan_time_s"] == pytest.approx(spent, rel=1e-12)
    plan = read_plan(tmp_path / "plan.h5")
    assert plan.robot is None
    assert data["motion_time_s"] == pytest.approx(sum(each.duration_s for each in plan.phases))


def test_what_planning_took_is_printed(
    call: Call, capsys: pytest.CaptureFixture[str], planned: Planned, scene: Path, tmp_path: Path
) -> None:
    show_phases(planned, Output(json_output=False))
    said = capsys.readouterr().out
    assert f"postures: found after {planned.summary['postures']['starts']} start" in said
    assert "s planning, " in said
    said = call("plan", scene, "-o", tmp_path / "tool.h5", "--no-hand").out
    assert "postures" not in said
    assert "s planning, 2.3 s motion" in said  # lift 1.5 s, addition 0.8 s


@pytest.mark.slow  # every figure of a plan
def test_run_without_the_hand(call: Call, scene: Path, tmp_path: Path) -> None:
    answer = call("run", scene, "--out", tmp_path, "--no-hand", "--no-view", "--json")
    assert answer.code == 0
    assert len(answer.data["phases"]) == 2
    assert read_plan(tmp_path / "plan.h5").robot is None


def test_a_violation_names_the_joint(call: Call, planned: Planned, tmp_path: Path) -> None:
    path, robot = tmp_path / "tampered.h5", planned.plan.robot
    assert robot is not None
    path.write_bytes(Path(planned.summary["plan"]).read_bytes())
    with h5py.File(path, "r+") as file:
        file["phases/00_lift/robot/q"][:, robot.joint_names.index("WRJ1")] += 3.0
    answer = call("certify", path)
    assert answer.code == 1
    assert "joint_position WRJ1" in answer.out
