"""``pivotgait sweep``: what it prints, and what it refuses."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Call = Callable[..., Any]
STUDY = """\
schema: pivotgait-study/1
name: few
scene: knife
compute: static
axes:
  contacts.*.friction: {values: [0.1, 0.8]}
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "few.yaml"
    path.write_text(STUDY, encoding="utf-8")
    return path


def test_sweep_and_sweep_again(call: Call, study: Path, tmp_path: Path) -> None:
    answer = call("sweep", study, "--out", tmp_path / "out", "--workers", 1, "--json")
    assert answer.code == 0
    data = answer.data
    assert (data["cells"], data["computed"], data["already_there"]) == (2, 2, 0)
    assert data["statuses"] == {"done": 2}
    assert (data["feasible"], data["workers"]) == (1, 1)
    assert data["seconds"] > 0.0
    again = call("sweep", study, "--out", tmp_path / "out", "--workers", 1)
    assert again.code == 0
    assert "feasible: 1 of 2 (50.0 %)" in again.out
    assert "2 of 2 cells are done already" in again.err


def test_a_sweep_in_which_nothing_could_be_computed_fails(
    call: Call, study: Path, tmp_path: Path
) -> None:
    study.write_text(STUDY.replace("[0.1, 0.8]", "[-1, -2]"), encoding="utf-8")
    answer = call("sweep", study, "--out", tmp_path / "out", "--workers", 1, "--json")
    assert answer.code == 1
    assert answer.data["statuses"] == {"invalid": 2}


def test_dry_run_writes_nothing(call: Call, study: Path, tmp_path: Path) -> None:
    answer = call("sweep", study, "--out", tmp_path / "out", "--dry-run", "--json", "--workers", 3)
    assert answer.code == 0
    data = answer.data
    assert (data["cells"], data["parts"], data["workers"]) == (2, 1, 3)
    assert data["cell_s"] > 0.0
    assert data["expected_s"] == pytest.approx(2 * data["cell_s"] / 3)
    assert not (tmp_path / "out").exists()


def test_studies_are_listed(call: Call) -> None:
    assert "knife_friction" in call("sweep", "--list").out
    data = call("sweep", "--list", "--json").data
    assert {"name", "compute", "cells", "description"} == data["studies"][0].keys()


def test_an_exported_study_is_a_study(call: Call, tmp_path: Path) -> None:
    exported = call("sweep", "--export", "knife_uncertainty")
    assert exported.code == 0
    path = tmp_path / "mine.yaml"
    path.write_text(exported.out, encoding="utf-8")
    answer = call("sweep", path, "--dry-run", "--workers", 1, "--json")
    assert answer.data["cells"] == 2000


BAD: dict[str, tuple[list[str], list[str]]] = {
    "no study": (["sweep"], ["knife_friction"]),
    "no out": (["sweep", "few.yaml"], ["--out", "--dry-run"]),
    "out is empty": (["sweep", "few.yaml", "--out", ""], ["new folder"]),
    "out is a file": (["sweep", "few.yaml", "--out", "few.yaml"], ["few.yaml", "another folder"]),
    "out below a file": (["sweep", "few.yaml", "--out", "few.yaml/out"], ["another folder"]),
    "out with a null byte": (["sweep", "few.yaml", "--out", "a\0b"], ["null byte"]),
    "out's name is too long": (["sweep", "few.yaml", "--out", 300 * "x"], ["another folder"]),
    "out in use": (["sweep", "few.yaml", "--out", "."], ["bad.yaml", "new folder"]),
    "dry run into a file": (["sweep", "few.yaml", "--out", "few.yaml", "--dry-run"], ["few.yaml"]),
    "unknown export": (["sweep", "--export", "knife"], ["knife_friction"]),
    "unknown study": (["sweep", "knife_frictoin", "--out", "out"], ["did you mean"]),
    "missing study": (["sweep", "missing.yaml", "--out", "out"], ["is not a file"]),
    "study with a null byte": (["sweep", "a\0b.yaml", "--out", "out"], ["is not a file"]),
    "bad study": (["sweep", "bad.yaml", "--out", "out"], ["axes.table.fricton", "'friction'"]),
    "no workers": (["sweep", "few.yaml", "--out", "out", "--workers", "0"], ["workers"]),
    "workers twice": (
        ["sweep", "few.yaml", "--out", "out", "--workers", "2", "--scheduler", "tcp://a:1"],
        ["--workers", "--scheduler"],
    ),
}


@pytest.mark.parametrize("flags", [[], ["--json"]], ids=["plain", "json"])
@pytest.mark.parametrize(("arguments", "words"), BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line(
    call: Call,
    study: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    words: list[str],
    flags: list[str],
) -> None:
    monkeypatch.chdir(study.parent)
    bad = STUDY.replace("contacts.*.friction", "table.fricton")
    (study.parent / "bad.yaml").write_text(bad, encoding="utf-8")
    answer = call(*arguments, *flags)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("pivotgait: error: ")
    assert answer.err.count("\n") == 1
    assert [word for word in words if word not in answer.err] == []
    assert sorted(file.name for file in study.parent.iterdir()) == ["bad.yaml", "few.yaml"]


def test_without_dask_the_line_says_what_to_install(
    call: Call, study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def missing(name: str, *rest: Any, **named: Any) -> Any:
        if name == "distributed":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", missing)
    answer = call("sweep", study, "--out", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:1")
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "pip install 'pivotgait[cluster]'" in answer.err


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "ftp://a:1"])
def test_a_scheduler_that_does_not_answer_is_told(
    call: Call, study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("pivotgait.sweeps.crews._ANSWER_S", 0.5)
    answer = call("sweep", study, "--out", tmp_path / "out", "--scheduler", address)
    assert answer.code == 2
    assert answer.err.count("\n") == 1, answer.err
    assert address in answer.err
    assert "dask scheduler" in answer.err
