"""A sweep's results, read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pivotgait.sweeps.errors import SweepFolderError
from pivotgait.sweeps.folder import PARTS, TIMINGS, file_name, read_manifest


def read_results(folder: Path) -> Any:
    """The results of a sweep, finished or not (a ``pyarrow.Table``), in the order of the cells.

    See :func:`pivotgait.sweeps.part_files.schema_of` for the columns; ``to_pandas()`` and
    ``column(name).to_numpy()`` lead on from there.

    Raises:
        SweepFolderError: the folder is no sweep's, or a part is damaged.
    """
    return _read(Path(folder), PARTS)


def read_timings(folder: Path) -> Any:
    """How long each cell took: ``cell`` and ``seconds`` (a ``pyarrow.Table``).

    Raises:
        SweepFolderError: as :func:`read_results`.
    """
    return _read(Path(folder), TIMINGS)


def _read(folder: Path, kind: str) -> Any:
    manifest = read_manifest(folder)
    files = [folder / kind / file_name(part) for part in range(manifest["parts"])]
    # a part counts when its results are there, whatever became of its timings
    there = [file for file in files if (folder / PARTS / file.name).exists()]
    if not there:
        mend = "go on with the sweep"
        raise SweepFolderError("holds no results yet", where=str(folder)[:80], mend=mend)
    try:
        tables = [pq.ParquetFile(file).read() for file in there]
    except (OSError, pa.ArrowException) as error:
        mend = f"delete what is damaged in {PARTS}/ and give the sweep's command again"
        raise SweepFolderError(f"is damaged: {error}", where=str(folder)[:80], mend=mend) from error
    return pa.concat_tables(tables).replace_schema_metadata()
