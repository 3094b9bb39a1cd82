"""Sweeps by workers: any number of them, killed at any moment, gives the same bytes."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pivotgait.sweeps import PartSummary, Study, parse_study, read_results, run_sweep
from pivotgait.sweeps.folder import MANIFEST
from tests.sweeps.cases import GRID, TROUBLED
from tests.sweeps.test_folder import content

KILLED = """\
schema: pivotgait-study/1
name: killed
scene: knife
compute: static
axes:
  table.friction: {linspace: {from: 0.1, to: 0.9, count: 40}}
  contacts.*.friction: {linspace: {from: 0.2, to: 1.0, count: %d}}
"""


def start(study: Path, out: Path, workers: int) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "pivotgait", "sweep", str(study), "--out", str(out)]
    return subprocess.Popen(
        [*command, "--workers", str(workers)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def done(out: Path) -> int:
    """Number of parts that are there."""
    return len(list((out / "parts").glob("*.parquet")))


def kill_at(study: Path, out: Path, workers: int, least: int, after_s: float) -> int:
    """Kill a sweep so long after so many parts were there; returns how many there are then."""
    process = start(study, out, workers)
    try:
        while process.poll() is None and not ((out / MANIFEST).exists() and done(out) >= least):
            time.sleep(0.01)
        time.sleep(after_s)
    finally:
        process.kill()
        process.wait()
    return done(out)


def kill_and_resume(folder: Path, columns: int, kills: int, workers: int) -> None:
    text = KILLED % columns
    study = parse_study(text)
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    run_sweep(study, folder / "whole", workers=workers)
    count = done(folder / "whole")
    left = []
    for k, moment in enumerate(np.random.default_rng(0).uniform(0.0, 1.0, kills)):
        least = k * count // (kills + 1)
        left.append(kill_at(folder / "study.yaml", folder / "out", workers, least, moment))
    assert left == sorted(left)
    assert left[0] < count
    assert left[-1] > 0
    assert start(folder / "study.yaml", folder / "out", workers).wait() == 0
    assert content(folder / "out") == content(folder / "whole")
    cells = read_results(folder / "out").column("cell").to_pylist()
    assert cells == list(range(study.cells.count))


def test_killed_twice_and_resumed(tmp_path: Path) -> None:
    kill_and_resume(tmp_path, columns=40, kills=2, workers=1)


@pytest.mark.slow
def test_killed_ten_times_and_resumed(tmp_path: Path) -> None:
    kill_and_resume(tmp_path, columns=400, kills=10, workers=2)


def test_failing_cells_are_results_like_others(tmp_path: Path) -> None:
    head = GRID[: GRID.index("axes:")]
    study = parse_study(head + "axes:\n  contacts.*.friction: {values: [0.1, 0.7, 0.8, 0.9]}\n")
    told: list[PartSummary] = []
    found = run_sweep(study, tmp_path, workers=1, progress=told.append, command=TROUBLED)
    assert (found.cells, found.computed, found.workers) == (4, 4, 1)
    assert found.counts == {"done": 3, "crash": 1, "feasible": 2}
    assert [each.counts for each in told] == [found.counts]
    table = read_results(tmp_path).to_pydict()
    assert table["status"] == ["done", "done", "done", "crash"]
    assert table["reason"][3] == "the process ended with code 7"
    assert (table["feasible"][3], table["depth_N"][3]) == (None, None)
    again = run_sweep(study, tmp_path, workers=1)
    assert (again.computed, again.counts) == (0, found.counts)


@pytest.mark.slow
def test_two_workers_give_the_bytes_of_one(tmp_path: Path) -> None:
    study = parse_study(KILLED % 40)
    run_sweep(study, tmp_path / "one", workers=1)
    run_sweep(study, tmp_path / "two", workers=2)
    assert content(tmp_path / "one") == content(tmp_path / "two")


@pytest.mark.slow
def test_a_cluster_gives_the_bytes_of_processes_here(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    study = parse_study(KILLED % 40)
    run_sweep(study, tmp_path / "here", workers=1)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        found = run_sweep(study, tmp_path / "there", scheduler=cluster.scheduler_address)
    assert found.workers == 2
    assert content(tmp_path / "there") == content(tmp_path / "here")


def test_progress_and_rest_agree(grid: Study, tmp_path: Path) -> None:
    told: list[PartSummary] = []
    found = run_sweep(grid, tmp_path, workers=1, progress=told.append)
    assert sum(each.cells for each in told) == found.computed == found.cells == 30
    assert found.counts["done"] == 30
    assert 0 < found.counts["feasible"] < 30
