"""Rows of a sweep report's tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pivotgait.plotting.parameters import parameter_label, parameter_words
from pivotgait.reporting.numbers import number
from pivotgait.reporting.study_figures import axis_shares
from pivotgait.sweeps import STATUSES
from pivotgait.sweeps.study_results import StudyResults

ROWS_MAX = 8
REASONS_MAX = 6
REASON_LENGTH = 110


@dataclass(frozen=True)
class Table:
    """A table of a sweep's page.

    Attributes:
        title: above it.
        head: names of the columns; the first one is a text.
        rows: cells as texts.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def headline(results: StudyResults) -> str:
    """The sweep in one line."""
    feasible = results.column("feasible")
    known, held = int(np.sum(~np.isnan(feasible))), int(np.nansum(feasible))
    share = f" ({100.0 * held / known:.1f} %)" if known else ""
    return f"{held} of {known} cells feasible{share}"


def study_tables(results: StudyResults) -> Iterator[Table]:
    """Shares along each axis, binding limits, statuses and reasons."""
    drawn = results.cells.draws > 1
    rows: list[tuple[str, ...]] = []
    for axis in axis_shares(results):
        picks = np.unique(np.linspace(0, len(axis.values) - 1, ROWS_MAX).round().astype(int))
        for k in picks.tolist() if len(axis.values) > ROWS_MAX else range(len(axis.values)):
            low, high = axis.interval[k]
            shown = _shown(axis.parameter, axis.values[k])
            shown = f"about {shown}" if axis.drawn else shown
            share = f"{100.0 * axis.feasible[k] / max(axis.count[k], 1.0):.1f} %"
            interval = f"{100.0 * low:.1f} to {100.0 * high:.1f} %"
            cells = (interval, f"{axis.count[k]:.0f}") if drawn else (f"{axis.count[k]:.0f}",)
            rows.append((parameter_words(axis.parameter), shown, share, *cells))
    if rows:
        last = ("95 % interval", "Cells") if drawn else ("Cells",)
        head = ("Parameter", "Value", "Feasible", *last)
        yield Table("Feasible cells along each parameter", head, tuple(rows))
    if "binding" in results.table.column_names:
        yield _bindings(results)
    counts = results.counts("status")
    missing = results.cells.count - results.rows
    states: list[tuple[str, str, str]] = [
        (STATUSES[k], k, str(counts[k])) for k in STATUSES if counts[k]
    ]
    if missing:
        states.append(("not computed yet", "missing", str(missing)))
    yield Table("What became of the cells", ("Meaning", "Status", "Cells"), tuple(states))
    reasons = results.counts("reason").most_common(REASONS_MAX)
    if reasons:
        shortened = tuple((_short(text), str(count)) for text, count in reasons)
        yield Table("Most frequent reasons", ("Reason", "Cells"), shortened)


def _bindings(results: StudyResults) -> Table:
    feasible = results.table["feasible"].to_pylist()
    binding = results.table["binding"].to_pylist()
    counts = {True: dict[str, int](), False: dict[str, int]()}
    for held, limit in zip(feasible, binding, strict=True):
        if held is not None and limit:
            counts[held][limit] = counts[held].get(limit, 0) + 1
    names = sorted({*counts[True], *counts[False]}, key=lambda each: -counts[False].get(each, 0))
    rows = tuple(
        (name, str(counts[False].get(name, 0)), str(counts[True].get(name, 0))) for name in names
    )
    head = ("Limit and contact", "Infeasible cells", "Feasible cells")
    return Table("The limit that binds, or comes nearest", head, rows)


def _shown(parameter: str, value: float | str) -> str:
    return value if isinstance(value, str) else number(parameter_label(parameter).scale * value)


def _short(text: str) -> str:
    return text if len(text) <= REASON_LENGTH else f"{text[:REASON_LENGTH]}…"
