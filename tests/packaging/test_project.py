"""The project's own files agree with one another."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

import pivotgait

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    found = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert isinstance(found, dict)
    return found


def constraints() -> list[str]:
    return (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()


def normalised(requirement: str) -> str:
    """Name of the package in a requirement, as PEP 503 compares it."""
    name = re.match(r"[A-Za-z0-9._-]+", requirement)
    assert name, requirement
    return re.sub(r"[-_.]+", "-", name[0]).lower()


def test_versions_agree(project: dict[str, Any]) -> None:
    assert project["version"] == pivotgait.__version__
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(
        rf"^version: [\"']?{re.escape(pivotgait.__version__)}\b", citation, re.MULTILINE
    )
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## \[?([^\]\s]+)", changelog, re.MULTILINE)
    assert newest
    assert newest[1] in ("Unreleased", pivotgait.__version__)


@pytest.mark.parametrize("name", ["LICENSE", "CITATION.cff", "CHANGELOG.md", "README.md"])
def test_file_is_there_and_says_something(name: str) -> None:
    assert len((ROOT / name).read_text(encoding="utf-8").strip()) > 0


def test_licence_is_the_one_the_project_names(project: dict[str, Any]) -> None:
    assert project["license"] == "BSD-2-Clause"
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert "Redistribution and use in source and binary forms" in text
    assert "Neither the name" not in text  # that clause would make it BSD-3-Clause


def test_constraints_hold_names_and_versions_only() -> None:
    lines = constraints()
    pattern = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*==[0-9][A-Za-z0-9.!+]*")
    assert [line for line in lines if not pattern.fullmatch(line)] == []
    names = [normalised(line) for line in lines]
    assert len(names) == len(set(names))


def test_every_dependency_is_pinned(project: dict[str, Any]) -> None:
    pinned = {normalised(line) for line in constraints()}
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *extras["dev"], *extras["mujoco"]]
    assert [each for each in wanted if normalised(each) not in pinned] == []


def test_the_command_is_the_entry_point(project: dict[str, Any]) -> None:
    module, function = project["scripts"]["pivotgait"].split(":")
    assert callable(getattr(__import__(module, fromlist=[function]), function))
