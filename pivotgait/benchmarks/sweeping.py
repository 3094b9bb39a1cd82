"""A sweep of static cells by two workers against one, on processes here and on a Dask cluster."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pivotgait.sweeps import Study, parse_study, run_sweep

CELLS_PER_ROW, ROWS, QUICK_ROWS = 1000, 100, 20
"""A hundred thousand cells; the quick form is short enough for starting up to weigh in it."""
WORKERS = 2

_STUDY = """\
schema: pivotgait-study/1
name: throughput
scene: knife
compute: static
set: {{allocation.friction_reserve: 0}}
axes:
  table.friction: {{linspace: {{from: 0.1, to: 1.0, count: {rows}}}}}
  contacts.*.friction: {{linspace: {{from: 0.1, to: 1.2, count: {cells}}}}}
"""


def sweep_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Seconds of whole sweeps, starting up included, by two workers and by one.

    Args:
        quick: fewer cells.

    Returns:
        One dict for processes and, where Dask is installed, one for a local cluster, as
        :func:`pivotgait.benchmarks.allocation_rows`; the peer is the same with one worker.
    """
    study = parse_study(_STUDY.format(rows=QUICK_ROWS if quick else ROWS, cells=CELLS_PER_ROW))
    rows = [_row(study, "processes", *(_by_processes(study, n) for n in (WORKERS, 1)))]
    if _dask_is_here():
        rows.append(_row(study, "Dask", *(_by_dask(study, n) for n in (WORKERS, 1))))
    return rows


def _row(study: Study, crew: str, ours: float, peer: float) -> dict[str, Any]:
    return {
        "name": f"sweep of {study.cells.count} static cells, {crew}: {WORKERS} workers",
        "ours_s": ours,
        "peer": "the same, 1 worker",
        "peer_s": peer,
        "ratio": peer / ours,
    }


def _by_processes(study: Study, workers: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        return run_sweep(study, Path(folder) / "out", workers=workers).seconds


def _by_dask(study: Study, workers: int) -> float:
    with tempfile.TemporaryDirectory() as folder, _cluster(workers) as address:
        return run_sweep(study, Path(folder) / "out", scheduler=address).seconds


def _dask_is_here() -> bool:
    try:
        import distributed  # noqa: F401
    except ImportError:
        return False
    return True


@contextmanager
def _cluster(workers: int) -> Iterator[str]:
    from distributed import LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address
