"""Plan files: what is written is read; nothing else is read as a plan."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import MappingProxyType

import h5py
import numpy as np
import pytest

from pivotgait.exceptions import PlanFileError
from pivotgait.plans import GaitPlan, read_plan, with_certificate, write_plan
from pivotgait.plans.hdf5_writer import plan_to_bytes


def same(left: object, right: object) -> bool:
    """Equality of records, arrays bit by bit."""
    if is_dataclass(left):
        names = [field.name for field in fields(left)]
        return all(same(getattr(left, name), getattr(right, name)) for name in names)
    if isinstance(left, np.ndarray):
        return left.dtype == right.dtype and np.array_equal(left, right)
    if isinstance(left, dict | MappingProxyType):
        return left.keys() == right.keys() and all(same(left[k], right[k]) for k in left)
    if isinstance(left, tuple):
        return len(left) == len(right) and all(map(same, left, right))
    return left == right


@pytest.fixture(params=["plan", "robot_plan"])
def any_plan(request: pytest.FixtureRequest) -> GaitPlan:
    return request.getfixturevalue(request.param)


@pytest.fixture
def path(plan: GaitPlan, tmp_path: Path) -> Path:
    write_plan(plan, tmp_path / "plan.h5")
    return tmp_path / "plan.h5"


def test_read_gives_what_was_written(any_plan: GaitPlan, tmp_path: Path) -> None:
    write_plan(any_plan, tmp_path / "any.h5")
    assert same(read_plan(tmp_path / "any.h5"), any_plan)


def test_order_of_contacts_and_fingers_is_kept(robot_plan: GaitPlan, tmp_path: Path) -> None:
    """Not the alphabet's, and the same bytes when read and written again."""
    for names in (["pivot", "thumb", "index"], ["index", "pivot", "thumb"]):
        phases = tuple(
            replace(phase, contacts={name: phase.contacts[name] for name in names})
            for phase in robot_plan.phases
        )
        write_plan(replace(robot_plan, phases=phases), tmp_path / "a.h5")
        read = read_plan(tmp_path / "a.h5")
        assert [list(phase.contacts) for phase in read.phases] == [names] * len(phases)
        assert list(read.robot.fingers) == list(robot_plan.robot.fingers) == ["thumb", "index"]
        write_plan(read, tmp_path / "b.h5")
        assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_read_arrays_are_read_only(path: Path) -> None:
    with pytest.raises(ValueError, match="read-only"):
        read_plan(path).phases[0].tool.position[0] = 0.0


def test_same_plan_same_bytes_in_another_process(any_plan: GaitPlan, tmp_path) -> None:
    path, again = tmp_path / "any.h5", tmp_path / "again.h5"
    write_plan(any_plan, path)
    code = (
        "import sys; from pivotgait.plans import *; write_plan(read_plan(sys.argv[1]), sys.argv[2])"
    )
    subprocess.run([sys.executable, "-c", code, path, again], check=True)
    assert again.read_bytes() == path.read_bytes() == plan_to_bytes(any_plan)


def test_layout_is_the_contract(path: Path) -> None:
    """Names, types and attributes that other programs rely on."""
    with h5py.File(path) as file:
        assert file.attrs["schema"] in (b"pivotgait-plan/1", "pivotgait-plan/1")
        assert set(file.attrs) == {
            "schema", "scene", "seed", "versions", "certificate", "gravity",
        }  # fmt: skip
        assert set(file) == {"tool", "table", "phases"}
        assert set(file["tool"].attrs) == {"name", "mass", "urdf"}
        assert set(file["tool"]) == {"inertia", "pivot_in_tool", "centre_of_mass_in_root"}
        assert file["table"].attrs["height"] == 0.7
        removal = file["phases/01_removal"]
        assert set(removal.attrs) == {"kind", "finger"}
        assert set(removal) == {"time", "tool", "contacts"}
        assert removal["tool/orientation"].shape == (4, 4)
        assert set(removal["contacts"]) == {"pivot", "thumb", "index"}
        index = removal["contacts/index"]
        assert set(index.attrs) == {"friction", "normal_min", "normal_max"}
        assert {name: index[name].shape for name in index} == {
            "point": (3,), "normal": (3,), "force": (4, 3),
        }  # fmt: skip
        kinds: list[str] = []
        file.visititems(lambda _, node: kinds.append(getattr(node, "dtype", np.dtype("f8")).str))
        assert set(kinds) == {"<f8"}


def test_layout_of_the_robot_is_the_contract(robot_plan: GaitPlan, tmp_path: Path) -> None:
    write_plan(robot_plan, tmp_path / "plan.h5")
    with h5py.File(tmp_path / "plan.h5") as file:
        robot, finger = file["robot"], file["robot/fingers/thumb"]
        assert set(robot.attrs) == {"urdf", "joint_names", "couplings", "never_touch"}
        names = tuple(name.decode() for name in robot.attrs["joint_names"])
        assert names == robot_plan.robot.joint_names
        assert json.loads(robot.attrs["couplings"]) == [["FFJ1", "FFJ2"]]
        assert set(robot) == {"fingers"}
        assert set(robot["fingers"]) == {"thumb", "index"}
        assert set(finger.attrs) == {"tip_frame", "tip_radius"}
        assert finger.attrs["tip_radius"] == 0.0075
        motion = file["phases/01_removal/robot"]
        assert {name: motion[name].shape for name in motion} == dict.fromkeys(
            ("q", "v", "a", "tau"), (4, 4)
        )


def test_text_longer_than_64_kb(plan: GaitPlan, tmp_path: Path) -> None:
    long = replace(plan, tool=replace(plan.tool, urdf="<ä/>\n" * 100_000))
    write_plan(long, tmp_path / "plan.h5")
    assert read_plan(tmp_path / "plan.h5").tool.urdf == long.tool.urdf


@pytest.mark.parametrize("text", ["", " ", "\n"])
def test_empty_text(plan: GaitPlan, tmp_path: Path, text: str) -> None:
    write_plan(replace(plan, scene=text), tmp_path / "plan.h5")
    assert read_plan(tmp_path / "plan.h5").scene == text


def test_certificate_is_stored(plan: GaitPlan, path: Path) -> None:
    certificate = {"valid": False, "residuals": {"force_balance_n": 0.5, "x": None}}
    with_certificate(path, certificate)
    stored = read_plan(path)
    assert stored.certificate == certificate
    assert same(replace(stored, certificate=None), plan)


def test_certificate_must_be_plain(plan: GaitPlan, path: Path) -> None:
    before = path.read_bytes()
    for wrong in ({"x": float("nan")}, {"x": np.zeros(2)}, {"x": object()}):
        with pytest.raises(PlanFileError, match="JSON"):
            with_certificate(path, wrong)
    assert path.read_bytes() == before


@pytest.mark.parametrize("text", ["a\0b", "\ud800"])
def test_text_that_a_file_cannot_hold(plan: GaitPlan, tmp_path: Path, text: str) -> None:
    with pytest.raises(PlanFileError, match="scene"):
        write_plan(replace(plan, scene=text), tmp_path / "plan.h5")
    assert list(tmp_path.iterdir()) == []


class Interrupt(BaseException):
    pass


@pytest.mark.parametrize("error", [OSError("disk full"), Interrupt()])
@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_failed_write_leaves_the_old_file_alone(plan, path, monkeypatch, error, step) -> None:
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(*((os, "fsync") if step == "fsync" else (Path, "replace")), fail)
    with pytest.raises((PlanFileError, Interrupt)):
        write_plan(replace(plan, seed=1), path)
    assert [file.name for file in path.parent.iterdir()] == ["plan.h5"]
    assert path.read_bytes() == before


def test_writing_where_one_cannot(plan: GaitPlan, tmp_path: Path) -> None:
    for target in (tmp_path, tmp_path / "missing" / "plan.h5", Path(), Path("a\0b")):
        with pytest.raises(PlanFileError):
            write_plan(plan, target)
    assert list(tmp_path.iterdir()) == []


def test_unreadable_plan_is_not_written(plan: GaitPlan, tmp_path: Path) -> None:
    nan = replace(plan, gravity=np.array([0.0, np.nan, 0.0]))
    with pytest.raises(PlanFileError, match="gravity"):
        write_plan(nan, tmp_path / "plan.h5")
    assert list(tmp_path.iterdir()) == []
