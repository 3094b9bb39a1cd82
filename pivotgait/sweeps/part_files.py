"""A part's results as Parquet: one row a cell, typed columns, readable by any tool."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pivotgait.sweeps.cells import Cell, cell_hash
from pivotgait.sweeps.evaluator import COLUMNS
from pivotgait.sweeps.guard import Timed
from pivotgait.sweeps.outcome import Kind
from pivotgait.sweeps.study import Study

_METADATA_KEY = b"pivotgait"
_TYPES: Mapping[Kind, Any] = {
    "bool": pa.bool_(),
    "int": pa.int64(),
    "float": pa.float64(),
    "text": pa.string(),
}


@dataclass(frozen=True)
class PartImage:
    """A part's two files.

    Attributes:
        results: Parquet file; the same bytes whenever and wherever the cells are computed.
        timings: Parquet file of the time each cell took.
        summary: of the part.
    """

    results: bytes
    timings: bytes
    summary: PartSummary


@dataclass(frozen=True)
class PartSummary:
    """What a part's file says of itself without being read through.

    Attributes:
        part: its number.
        study: digest of the study.
        cells: number of its cells.
        counts: number of cells by status; ``feasible`` counts those too.
    """

    part: int
    study: str
    cells: int
    counts: Mapping[str, int]


def schema_of(study: Study) -> Any:
    """The columns of a study's results (a ``pyarrow.Schema``).

    ``cell`` (number), ``hash`` (name by content), one column for each axis, ``draw``, ``status``
    (see :data:`pivotgait.sweeps.outcome.STATUSES`), ``reason``, and those of the computation.
    """
    cells = study.cells
    axes = [(a.parameter, _TYPES["text" if a.named else "float"]) for a in cells.axes]
    results = [(name, _TYPES[kind]) for name, kind in COLUMNS[study.config.compute].items()]
    head = [("cell", pa.int64()), ("hash", pa.string())]
    middle = [("draw", pa.int64()), ("status", pa.string()), ("reason", pa.string())]
    return pa.schema([*head, *axes, *middle, *results])


def part_image(
    study: Study, part: int, numbers: Sequence[int], timed: Sequence[Timed]
) -> PartImage:
    """The files of a part from the outcomes of its cells."""
    cells = [study.cells.cell(number) for number in numbers]
    counts = Counter[str](each.outcome.status for each in timed)
    counts["feasible"] = sum(bool(each.outcome.results.get("feasible")) for each in timed)
    summary = PartSummary(part, study.digest, len(cells), dict(sorted(counts.items())))
    columns: dict[str, list[Any]] = {
        "cell": list(numbers),
        "hash": _hashes(study, cells),
        **{axis.parameter: [c.values[axis.parameter] for c in cells] for axis in study.cells.axes},
        "draw": [cell.draw for cell in cells],
        "status": [each.outcome.status for each in timed],
        "reason": [each.outcome.reason for each in timed],
    }
    for name in COLUMNS[study.config.compute]:
        columns[name] = [each.outcome.results.get(name) for each in timed]
    metadata = {_METADATA_KEY: json.dumps(asdict(summary), sort_keys=True).encode()}
    table = pa.table(columns, schema=schema_of(study).with_metadata(metadata))
    times = pa.table({"cell": list(numbers), "seconds": [each.seconds for each in timed]})
    return PartImage(_parquet(table), _parquet(times), summary)


def _hashes(study: Study, cells: Sequence[Cell]) -> list[str]:
    draw_matters = study.config.compute == "trials"  # each has seeds of its own
    return [cell_hash(study.digest, cell, draw_matters=draw_matters) for cell in cells]


def read_summary(path: Path) -> PartSummary | None:
    """What a part's file says of itself, None if it is no such file or is damaged."""
    try:
        found = pq.read_metadata(path)
        note = json.loads(found.metadata[_METADATA_KEY])
        return PartSummary(note["part"], note["study"], found.num_rows, note["counts"])
    except (OSError, pa.ArrowException, KeyError, TypeError, ValueError):
        return None


def _parquet(table: Any) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd")
    return bytes(sink.getvalue())
