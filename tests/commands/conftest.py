"""The command line called in this process, and one small run to look at."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from pivotgait.cli import main
from pivotgait.models import export_scene


@dataclass(frozen=True)
class Answer:
    """What a command left behind."""

    code: int
    out: str
    err: str

    @property
    def data(self) -> dict[str, Any]:
        """Its stdout as JSON; fails on anything beside one object."""
        found = json.loads(self.out)
        assert isinstance(found, dict)
        return found


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """Run ``pivotgait`` with arguments."""

    def run(*arguments: object) -> Answer:
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main([str(each) for each in arguments])
        code = caught.value.code
        assert isinstance(code, int)
        return Answer(code, *capsys.readouterr())

    return run


@pytest.fixture(scope="session")
def small_scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wrench's scene with fewer steps, without its last phase and its hand."""
    lines = [each for each in export_scene("wrench").splitlines() if "kind: relocation" not in each]
    del lines[lines.index("robot:") : lines.index("contacts:")]
    last = next(k for k, line in enumerate(lines) if "contact: index_side_near, dur" in line)
    del lines[last]
    text = "\n".join(lines) + "\n"
    for old, new in (("steps: 75", "steps: 30"), ("steps: 40", "steps: 10"), (" 64", " 24")):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path_factory.mktemp("scene") / "small.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def small_run(small_scene: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of ``pivotgait run small.yaml``."""
    folder = tmp_path_factory.mktemp("run") / "out"
    with pytest.raises(SystemExit) as caught:
        main(["run", str(small_scene), "--out", str(folder)])
    assert caught.value.code == 0
    return folder
