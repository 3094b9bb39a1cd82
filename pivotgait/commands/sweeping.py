"""``sweep``: a study over its cells, here or on a cluster."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from time import monotonic
from typing import Any

from rich.markup import escape
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from pivotgait.commands.output import Output
from pivotgait.exceptions import InputError
from pivotgait.sweeps import (
    STATUSES,
    PartSummary,
    Study,
    SweepFolder,
    SweepSummary,
    builtin_studies,
    crew,
    estimate,
    export_study,
    load_study,
    run_sweep,
)
from pivotgait.sweeps.folder import check_folder, manifest_of

_LOG_EVERY_S = 30.0
"""Between lines of progress where stderr is no terminal."""


def run_sweep_command(
    study: str | None,
    folder: Path | None,
    workers: int | None,
    scheduler: str | None,
    out: Output,
    *,
    dry_run: bool = False,
    listed: bool = False,
    export: str | None = None,
) -> int:
    """Sweep, tell what a sweep would take, or show the studies; returns the exit code.

    The code is 1 if not a single cell could be computed.
    """
    if export is not None:
        text = export_study(export)
        if not out.json:
            sys.stdout.write(text)
        out.emit({"name": export, "yaml": text})
        return 0
    if listed:
        return _list(out)
    if study is None:
        mend = f"give a YAML file or one of {', '.join(builtin_studies())}"
        raise InputError("no study", where="sweep", mend=mend)
    if dry_run:
        return _tell(load_study(study), folder, workers, scheduler, out)
    if folder is None:
        mend = "give --out DIR, or --dry-run"
        raise InputError("no folder for the results", where="sweep", mend=mend)
    loaded = load_study(study)
    found = _sweep(loaded, folder, workers, scheduler, out)
    _show(loaded, folder, found, out)
    return 0 if found.counts.get("done", 0) else 1


def _list(out: Output) -> int:
    studies = [load_study(name) for name in builtin_studies()]
    rows = [
        (s.config.name, s.config.compute, f"{s.cells.count}", escape(s.config.description))
        for s in studies
    ]
    columns = [("study", "left"), ("computes", "left"), ("cells", "right"), ("what", "left")]
    out.table("built-in studies", columns, rows)
    out.say("print one to start from: pivotgait sweep --export knife_friction")
    names = ("name", "compute", "cells", "description")
    shown = [dict(zip(names, (*row[:2], int(row[2]), row[3]), strict=True)) for row in rows]
    out.emit({"studies": shown})
    return 0


def _tell(
    study: Study, folder: Path | None, workers: int | None, scheduler: str | None, out: Output
) -> int:
    if folder is not None:
        check_folder(folder, manifest_of(study))
    with crew(workers, scheduler) as count, out.progress("measuring some cells", 1):
        found = estimate(study)
    expected = found.seconds(count)
    out.say(f"study: {study.config.name}, computes {study.config.compute}")
    for axis in study.cells.axes:
        values = f"{study.cells.draws} draws" if axis.drawn else f"{axis.count} values"
        out.say(f"  {escape(axis.parameter)}: {values}, {axis.kind}")
    out.say(f"cells: {found.cells} in {found.parts} parts")
    plural = "" if count == 1 else "s"
    out.say(
        f"expected: {_duration(expected)} with {count} worker{plural}, "
        f"{1e3 * found.cell_s:.3g} ms a cell (mean of {found.measured})"
    )
    out.emit(
        {
            "study": study.config.name,
            "compute": study.config.compute,
            "cells": found.cells,
            "parts": found.parts,
            "measured_cells": found.measured,
            "cell_s": found.cell_s,
            "workers": count,
            "expected_s": expected,
        }
    )
    return 0


def _sweep(
    study: Study, folder: Path, workers: int | None, scheduler: str | None, out: Output
) -> SweepSummary:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TextColumn("{task.completed}/{task.total}"),
        _Rate(),
        TimeRemainingColumn(),
    )
    silent = not out.log.is_terminal
    with Progress(*columns, console=out.log, transient=True, disable=silent) as bar:
        task = bar.add_task(study.config.name, total=study.cells.count)
        said = monotonic()

        def begun(kept: SweepFolder) -> None:
            bar.update(task, total=study.cells.count - kept.done_cells)
            if kept.done:
                out.log.print(f"{kept.done_cells} of {study.cells.count} cells are done already")

        def progress(part: PartSummary) -> None:
            nonlocal said
            bar.advance(task, part.cells)
            if silent and monotonic() - said > _LOG_EVERY_S:
                said = monotonic()
                done, total = bar.tasks[task].completed, bar.tasks[task].total
                out.log.print(f"{done:.0f}/{total:.0f} cells")

        return run_sweep(
            study, folder, workers=workers, scheduler=scheduler, begun=begun, progress=progress
        )


def _show(study: Study, folder: Path, found: SweepSummary, out: Output) -> None:
    rows = [
        (status, str(found.counts[status]), meaning)
        for status, meaning in STATUSES.items()
        if status in found.counts
    ]
    columns = [("status", "left"), ("cells", "right"), ("meaning", "left")]
    out.table(f"{study.config.name}: {folder}", columns, rows)
    done, feasible = found.counts.get("done", 0), found.counts.get("feasible", 0)
    share = f" ({100 * feasible / done:.1f} %)" if done else ""
    out.say(f"feasible: {feasible} of {done}{share}")
    rate = found.computed / found.seconds if found.seconds > 0.0 else 0.0
    out.say(
        f"computed: {found.computed} cells in {_duration(found.seconds)} "
        f"({rate:.3g} cells/s, {found.workers} workers)"
    )
    data: dict[str, Any] = {
        "study": study.config.name,
        "compute": study.config.compute,
        "out": os.fspath(folder),
        "cells": found.cells,
        "computed": found.computed,
        "already_there": found.cells - found.computed,
        "statuses": {k: v for k, v in found.counts.items() if k != "feasible"},
        "feasible": feasible,
        "seconds": found.seconds,
        "cells_per_s": rate,
        "workers": found.workers,
    }
    out.emit(data)


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.3g} s"
    if seconds < 6000.0:
        return f"{seconds / 60.0:.3g} min"
    return f"{seconds / 3600.0:.3g} h"


class _Rate(ProgressColumn):
    """Cells a second."""

    def render(self, task: Task) -> Text:
        """The rate, once there is one."""
        return Text("" if task.speed is None else f"{task.speed:.3g} cells/s")
