"""The wheel carries everything the package reads when it runs."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow  # builds in isolation, with hatchling from the package index


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "wheel", str(ROOT), "--no-deps", "-w", str(folder)]
    built = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert built.returncode == 0, built.stderr
    (found,) = folder.glob("pivotgait-*.whl")
    return found


def test_wheel_holds_code_scenes_models_and_templates(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for pattern in ("*.py", "models/scenes/*.yaml", "reporting/templates/*", "py.typed"):
        files = {
            f"pivotgait/{path.relative_to(ROOT / 'pivotgait').as_posix()}"
            for path in (ROOT / "pivotgait").rglob(pattern)
        }
        assert files <= names, f"missing: {sorted(files - names)}"
    models = {
        f"pivotgait/_data/{path.relative_to(ROOT).as_posix()}"
        for path in (ROOT / "urdf").rglob("*")
        if path.is_file()
    }
    assert "pivotgait/_data/urdf/chef_knife/chef_knife.urdf" in models
    assert models <= names, f"missing: {sorted(models - names)}"


def test_wheel_holds_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"pivotgait"}
    assert [name for name in names if name.endswith((".pyc", ".h5", ".part"))] == []


def test_package_works_from_the_wheel_alone(wheel: Path, tmp_path: Path) -> None:
    # unpacked where the source tree is out of reach: models come from the wheel
    zipfile.ZipFile(wheel).extractall(tmp_path)
    code = "from pivotgait.cli import main; main()"
    answer = subprocess.run(
        [sys.executable, "-c", code, "plan", "knife", "--no-hand", "-o", "plan.h5", "--json"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "PATH": ""},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    where = subprocess.run(
        [sys.executable, "-c", "import pivotgait; print(pivotgait.__file__)"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "PATH": ""},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert Path(where.stdout.strip()).is_relative_to(tmp_path)
