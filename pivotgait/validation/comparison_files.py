"""A comparison on disk: what was found as JSON, and the record of the run in each engine."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plans import GaitPlan
from pivotgait.validation.comparison import SCHEMA, CompareOptions, Comparison
from pivotgait.validation.record import RecordError, plan_digest, write_record
from pivotgait.validation.record_reading import RecordedRun, read_run
from pivotgait.validation.trial import TrialOptions, TrialResult
from pivotgait.validation.trials import TrialSet, stages_of

FOUND = "comparison.json"
_EVERY = 5
_MOST_BYTES = 20_000_000
_MEND = "write it with 'pivotgait compare -o'"


def run_file(simulator: str) -> str:
    """Name of the record of the nominal run in an engine."""
    return f"comparison_{simulator}.h5"


def write_comparison(
    found: Comparison, plan: GaitPlan, options: CompareOptions, folder: Path
) -> None:
    """Write ``comparison.json`` and both nominal runs, every fifth cycle, into a folder.

    Raises:
        InputError: a file cannot be written.
    """
    for simulator, result in zip(options.simulators, found.nominal, strict=True):
        run = TrialOptions(replace(options.run, simulator=simulator), perturbed=False)
        thin = (_thinned(result),)
        write_record(TrialSet(run, stages_of(plan, thin), thin), plan, folder / run_file(simulator))
    text = json.dumps(found.as_json(), indent=2, allow_nan=False) + "\n"
    try:
        write_atomically(text.encode(), folder / FOUND)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", where=FOUND) from error


@dataclass(frozen=True, eq=False)
class RecordedComparison:
    """A comparison read back.

    Attributes:
        found: what ``pivotgait compare --json`` printed.
        runs: the nominal run in each engine.
    """

    found: Mapping[str, Any]
    runs: tuple[RecordedRun, RecordedRun]


def read_comparison(folder: Path, plan: GaitPlan) -> RecordedComparison:
    """The comparison in a folder.

    Raises:
        RecordError: missing, damaged, of another schema or of another plan.
    """
    path = folder / FOUND
    try:
        if not path.is_file() or path.stat().st_size > _MOST_BYTES:
            raise RecordError("is no file, or too large", where=FOUND, mend=_MEND)
        found = json.loads(path.read_bytes())
        schema, digest = found["schema"], found["plan_sha256"]
        one, two = (str(each) for each in found["nominal"]["simulators"])
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordError("is damaged or no comparison", where=FOUND, mend=_MEND) from error
    if schema != SCHEMA:
        raise RecordError(f"has schema {str(schema)[:40]!r}", where=FOUND, mend=_MEND)
    if digest != plan_digest(plan):
        raise RecordError("is the comparison of another plan", where=FOUND, mend=_MEND)
    if not (one.isidentifier() and two.isidentifier()):  # they name files
        raise RecordError("names no simulators", where=FOUND, mend=_MEND)
    runs = (read_run(folder / run_file(one), plan), read_run(folder / run_file(two), plan))
    return RecordedComparison(found, runs)


def _thinned(result: TrialResult) -> TrialResult:
    assert result.series is not None  # `compare_engines` refuses runs without
    assert result.planned is not None
    rows = result.series.every(_EVERY)
    return replace(result, series=rows, planned=result.planned.every(_EVERY))
