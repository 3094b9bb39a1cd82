"""``baselines``: the same trials under every control law, and without pivoting."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pivotgait.atomic import write_atomically
from pivotgait.commands.output import Output
from pivotgait.commands.planning import writable
from pivotgait.exceptions import InputError
from pivotgait.plans import read_plan
from pivotgait.validation import (
    BASELINES,
    RunOptions,
    TrialOptions,
    TrialResult,
    TrialSet,
    run_baselines,
)


def run_baselines_command(
    path: Path,
    simulator: str,
    trials: int,
    seed: int,
    output: Path | None,
    out: Output,
    *,
    workers: int | None = None,
) -> int:
    """Run and compare; returns 0, since baselines are meant to fail.

    The summaries are written under ``validations``, where the report looks for them in
    ``summary.json``; other keys of the file stay.

    Raises:
        InputError: a plan that cannot be tried, or an output that is no summary.
    """
    if output is not None:
        writable(output)
        _known(output)
    plan = read_plan(path)
    options = TrialOptions(RunOptions(simulator=simulator), perturbed=trials > 1)
    with out.progress(f"baselines in {simulator}", trials * len(BASELINES)) as bar:

        def tell(_: TrialResult) -> None:
            bar.advance(bar.task_ids[0])

        seeds = range(seed, seed + trials)
        found = run_baselines(
            plan, seeds, options, folder=path.parent, workers=workers, progress=tell
        )
    summary = {"validations": [each.as_json() for each in found.values()]}
    if output is not None:
        text = json.dumps({**_known(output), **summary}, allow_nan=False, indent=1)
        write_atomically(text.encode(), output)
    show_baselines(found, out)
    out.emit({**summary, "plan": str(path), "output": str(output) if output else None})
    return 0


def _known(path: Path) -> dict[str, Any]:
    """What a summary holds already, so that its other keys stay.

    Raises:
        InputError: if the file is something else.
    """
    if not path.exists():
        return {}
    try:
        known = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError("is no JSON", where=path.name, mend="choose another file") from error
    if not isinstance(known, dict):
        raise InputError("is no summary", where=path.name, mend="choose another file")
    return known


def show_baselines(found: Mapping[str, TrialSet], out: Output) -> None:
    """Print how far the trials came, and the median figures of the runs."""
    columns = [("controller", "left"), *((name, "right") for name in _HEADS)]
    rows = [(name, *_row(trials)) for name, trials in found.items()]
    out.table("the same trials in every way", columns, rows)
    stages = [("controller", "left"), ("passed by stage", "left"), ("failures", "left")]
    out.table("where they failed", stages, [(n, *_ends(each)) for n, each in found.items()])


_HEADS = ("passed", "95 %", "hold", "load", "turn", "tip", "finger")
_FIGURES = {
    "holding_force_rms_N": "N",
    "loading_force_rms_N": "N",
    "orientation_deg": "deg",
    "tip_slip_mm": "mm",
    "fingertip_slip_mm": "mm",
}


def _row(trials: TrialSet) -> list[str]:
    summary: dict[str, Any] = trials.as_json()
    low, high = summary["wilson_95"]
    metrics = [each.metrics for each in trials.results if each.metrics is not None]
    figures = [
        f"{np.median([getattr(each, name) for each in metrics]):.2f} {unit}" if metrics else "-"
        for name, unit in _FIGURES.items()
    ]
    return [f"{trials.passed}/{summary['trials']}", f"{100 * low:.0f}-{100 * high:.0f} %", *figures]


def _ends(trials: TrialSet) -> tuple[str, str]:
    stages = ", ".join(f"{each.name} {each.passed}/{each.reached}" for each in trials.stages)
    return stages, ", ".join(f"{n} {name}" for name, n in trials.failures.items())
