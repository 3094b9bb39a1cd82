"""The folder of a sweep: refused, resumed, repaired, read back."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from pivotgait.sweeps import (
    Study,
    SweepFolderError,
    parse_study,
    read_manifest,
    read_results,
    read_timings,
    run_sweep,
)
from pivotgait.sweeps import folder as folder_module
from pivotgait.sweeps.evaluator import Evaluator
from pivotgait.sweeps.folder import MANIFEST, PARTS, open_folder
from pivotgait.sweeps.guard import Timed
from pivotgait.sweeps.part_files import part_image
from pivotgait.sweeps.parts import PART_CELLS, Parts
from tests.sweeps.cases import DRAWN, GRID


@pytest.fixture
def tens(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of ten cells."""
    monkeypatch.setitem(PART_CELLS, "static", 10)


def fill(path: Path, study: Study, seconds: float = 0.1) -> None:
    """Do what is missing, in this process."""
    work = Evaluator(study)
    with open_folder(path, study) as kept:
        for part in kept.missing():
            numbers = kept.parts.numbers(part)
            timed = [Timed(outcome, seconds) for outcome in work.outcomes(numbers)]
            kept.write(part_image(study, part, numbers, timed))


def content(path: Path) -> dict[str, bytes]:
    """Everything but timings."""
    files = [file for file in path.rglob("*") if file.is_file() and "timings" not in file.parts]
    return {str(file.relative_to(path)): file.read_bytes() for file in files}


@pytest.mark.usefixtures("tens")
def test_results_are_read_back_in_order(grid: Study, tmp_path: Path) -> None:
    fill(tmp_path / "out", grid)
    table = read_results(tmp_path / "out").to_pydict()
    assert table["cell"] == list(range(30))
    assert len(set(table["hash"])) == 30
    for number in range(30):
        for name, value in grid.cells.cell(number).values.items():
            assert table[name][number] == value
    expected = Evaluator(grid).outcomes(range(10))
    assert table["feasible"][:10] == [each.results["feasible"] for each in expected]
    assert table["depth_N"][:10] == [each.results["depth_N"] for each in expected]
    assert read_timings(tmp_path / "out").to_pydict()["seconds"] == [0.1] * 30
    manifest = read_manifest(tmp_path / "out")
    assert (manifest["cells"], manifest["part_cells"], manifest["parts"]) == (30, 10, 3)


@pytest.mark.usefixtures("tens")
def test_stopped_at_any_write_it_goes_on(
    grid: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Manifest, then timings and results of three parts: seven files, seven places to stop."""
    fill(tmp_path / "whole", grid)
    write = folder_module.write_atomically
    for stop in range(7):
        path, left = tmp_path / f"stop{stop}", [stop]

        def failing(data: bytes, file: Path, left: list[int] = left) -> None:
            if left[0] == 0:
                # what SIGKILL leaves of a file under way
                file.with_name(f".{file.name}.0.part").write_bytes(data[: len(data) // 2])
                raise KeyboardInterrupt
            left[0] -= 1
            write(data, file)

        monkeypatch.setattr(folder_module, "write_atomically", failing)
        with pytest.raises(KeyboardInterrupt):
            fill(path, grid)
        monkeypatch.setattr(folder_module, "write_atomically", write)
        fill(path, grid, seconds=0.2)
        assert content(path) == content(tmp_path / "whole")
        kept = 10 * (max(stop - 1, 0) // 2)
        times = read_timings(path).to_pydict()["seconds"]
        assert times == [0.1] * kept + [0.2] * (30 - kept)  # no cell is done twice


@pytest.mark.usefixtures("tens")
@pytest.mark.parametrize(
    "damage",
    [
        lambda file: file.write_bytes(b""),
        lambda file: file.write_bytes(file.read_bytes()[:-20]),
        lambda file: file.unlink(),
        lambda file: file.write_bytes(file.with_name("000000.parquet").read_bytes()),
    ],
    ids=["empty", "cut", "gone", "another"],
)
def test_damaged_parts_are_done_again(
    grid: Study, tmp_path: Path, damage: Callable[[Path], object]
) -> None:
    path = tmp_path / "out"
    fill(path, grid)
    whole = content(path)
    damage(path / PARTS / "000001.parquet")
    with open_folder(path, grid) as kept:
        assert list(kept.missing()) == [1]
        assert kept.done_cells == 20
        assert kept.counts["done"] == 20
    fill(path, grid)
    assert content(path) == whole


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (GRID.replace("[20, 40]", "[20, 30]"), "study, with other axes"),
        (GRID.replace("compute: static", "compute: removal"), "study, with other compute"),
        (GRID + "seed: 3\n", "study, with other seed"),
        (DRAWN, "study, with other name, axes, draws, seed"),
    ],
)
def test_another_study_is_refused(grid: Study, tmp_path: Path, other: str, words: str) -> None:
    path = tmp_path / "out"
    fill(path, grid)
    before = content(path)
    with pytest.raises(SweepFolderError, match=words), open_folder(path, parse_study(other)):
        pass
    assert content(path) == before


def test_another_order_of_the_axes_is_another_study(grid: Study, tmp_path: Path) -> None:
    lines = GRID.splitlines()
    swapped = "\n".join([*lines[:5], lines[6], lines[5], *lines[7:]])
    fill(tmp_path / "out", grid)
    with pytest.raises(SweepFolderError, match="axes"):
        fill(tmp_path / "out", parse_study(swapped))


def test_other_versions_are_refused(grid: Study, tmp_path: Path) -> None:
    fill(tmp_path, grid)
    manifest = json.loads((tmp_path / MANIFEST).read_text())
    manifest["versions"]["scipy"] = "0.1"
    (tmp_path / MANIFEST).write_text(json.dumps(manifest))
    with pytest.raises(SweepFolderError, match=r"scipy 0\.1"):
        fill(tmp_path, grid)


def test_a_folder_with_other_things_is_refused(grid: Study, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("do not touch")
    with pytest.raises(SweepFolderError, match=r"thesis\.tex.*new folder"):
        run_sweep(grid, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_folder_in_use_is_refused(grid: Study, tmp_path: Path) -> None:
    with (
        open_folder(tmp_path, grid),
        pytest.raises(SweepFolderError, match="another sweep is at work"),
    ):
        fill(tmp_path, grid)
    fill(tmp_path, grid)


@pytest.mark.parametrize("text", ["", "[]", '{"schema": "other/1"}', "\0"])
def test_a_broken_manifest_is_refused(grid: Study, tmp_path: Path, text: str) -> None:
    (tmp_path / MANIFEST).write_text(text)
    with pytest.raises(SweepFolderError, match=r"sweep|schema"):
        fill(tmp_path, grid)
    with pytest.raises(SweepFolderError):
        read_results(tmp_path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_refused(grid: Study, tmp_path: Path) -> None:
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    with pytest.raises(SweepFolderError, match="cannot be used"):
        run_sweep(grid, tmp_path / "out")


def test_there_are_no_results_before_the_first_part(grid: Study, tmp_path: Path) -> None:
    with open_folder(tmp_path, grid):
        pass
    with pytest.raises(SweepFolderError, match="no results yet"):
        read_results(tmp_path)


@pytest.mark.parametrize(
    ("cells", "parts", "size"), [(1, 1, 500), (500, 1, 500), (501, 2, 500), (10**9, 10_000, 10**5)]
)
def test_parts_cover_every_cell_once(cells: int, parts: int, size: int) -> None:
    cut = Parts.cut("static", cells)
    assert (cut.count, cut.size) == (parts, size)
    ranges = [cut.numbers(part) for part in range(cut.count)]
    assert ranges[0].start == 0
    assert ranges[-1].stop == cells
    assert all(a.stop == b.start for a, b in pairwise(ranges))
