"""The commands as processes of their own: what only a real stdout and exit code can show."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pivotgait.models import export_scene


def run(*arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "pivotgait", *map(str, arguments)],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONIOENCODING": "utf-8", **environment},
        timeout=120,
        check=False,
    )


def test_plan_and_certify(small_scene: Path, tmp_path: Path) -> None:
    path = tmp_path / "plan.h5"
    planned = run("plan", small_scene, "-o", path, "--json")
    assert planned.returncode == 0
    data = json.loads(planned.stdout)
    assert data["valid"] is True
    assert planned.stderr == ""
    certified = run("certify", path, "--json")
    assert certified.returncode == 0
    assert json.loads(certified.stdout) == data["certificate"]


def test_bad_input_is_one_line() -> None:
    answer = run("plan", "knif")
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert answer.stderr.startswith("pivotgait: error: unknown scene 'knif'")
    assert answer.stderr.count("\n") == 1


def test_debug_keeps_the_exit_code() -> None:
    answer = run("scenes", "--export", "knif", "--debug")
    assert answer.returncode == 2
    assert "Traceback (most recent call last)" in answer.stderr


def test_no_arguments_print_the_help() -> None:
    answer = run()
    assert "Usage" in answer.stdout + answer.stderr
    assert "Traceback" not in answer.stderr


def test_exported_scene_is_the_file_byte_by_byte() -> None:
    assert run("scenes", "--export", "knife").stdout == export_scene("knife")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_goes_away_ends_it_quietly(unbuffered: str) -> None:
    command = [sys.executable, "-m", "pivotgait", "scenes", "--export", "knife"]
    environment = {**os.environ, "PYTHONUNBUFFERED": unbuffered}
    reader, writer = os.pipe()
    os.close(reader)
    try:
        answer = subprocess.run(
            command,
            stdout=writer,
            stderr=subprocess.PIPE,
            env=environment,
            text=True,
            timeout=60,
            check=False,
        )
    finally:
        os.close(writer)
    assert answer.stderr == ""
    # not 0: what was said was not heard; not 1 or 2, which mean something else
    assert answer.returncode == 141


@pytest.mark.parametrize("width", ["60", "200"])
def test_tables_fit_any_terminal(width: str) -> None:
    answer = run("scenes", COLUMNS=width, NO_COLOR="1")
    assert answer.returncode == 0
    assert "screwdriver" in answer.stdout
