"""Every folder under urdf/ keeps the conventions that make one URDF good for all engines."""

from pathlib import Path

import pytest

import pivotgait
from pivotgait.models import model_names, urdf_root
from pivotgait.models.urdf import read_urdf

FOLDERS = sorted(path for path in urdf_root().iterdir() if path.is_dir())
URDFS = sorted(urdf_root().glob("*/*.urdf"))


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda path: path.name)
def test_folder_says_where_its_numbers_come_from(folder: Path) -> None:
    text = (folder / "README.md").read_text()
    assert "Source" in text
    assert (folder / f"{folder.name}.urdf").is_file()


@pytest.mark.parametrize("path", URDFS, ids=lambda path: path.stem)
def test_urdf_keeps_the_conventions(path: Path) -> None:
    summary = read_urdf(path)
    lines = summary.text.splitlines()
    assert summary.name == path.stem
    assert summary.version == "1.1"
    assert max(map(len, lines)) < 1000
    assert max(line.count("<") for line in lines) == 1, "one element per line"
    assert not any(word in summary.text for word in ("continuous", "<mimic", "<mesh", "xacro"))
    for link in summary.links.values():
        assert link.inertial is not None or link.name == summary.root


def test_the_tools_are_found() -> None:
    tools = {"chef_knife", "screwdriver", "wrench", "spatula", "table_knife"}
    assert tools <= set(model_names())


def test_an_installed_package_brings_its_own_models(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(pivotgait, "__file__", str(tmp_path / "pivotgait" / "__init__.py"))
    assert urdf_root() == tmp_path / "urdf", "a checkout"
    packed = tmp_path / "pivotgait" / "_data" / "urdf"
    packed.mkdir(parents=True)
    assert urdf_root() == packed
