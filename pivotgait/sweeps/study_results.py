"""A sweep's results as arrays over its grid, finished or not."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from pivotgait.frozen import Array
from pivotgait.sweeps.axes import Axis
from pivotgait.sweeps.cells import CellSpace
from pivotgait.sweeps.errors import SweepFolderError
from pivotgait.sweeps.folder import read_manifest
from pivotgait.sweeps.results import read_results, read_timings
from pivotgait.sweeps.study_config import StudyConfig


@dataclass(frozen=True, eq=False)
class StudyResults:
    """What a sweep's folder holds.

    Attributes:
        config: of the study.
        scene: YAML text of its scene.
        versions: of the packages that computed it.
        cells: all of them.
        table: the rows that are there (a ``pyarrow.Table``).
        seconds: that computing them took, summed over workers [s].
    """

    config: StudyConfig
    scene: str
    versions: Mapping[str, str]
    cells: CellSpace
    table: Any
    seconds: float

    @property
    def rows(self) -> int:
        """Number of cells that are done."""
        return int(self.table.num_rows)

    @property
    def grid_axes(self) -> tuple[Axis, ...]:
        """Axes with values of their own, in the study's order."""
        return tuple(axis for axis in self.cells.axes if not axis.drawn)

    @property
    def drawn_axes(self) -> tuple[Axis, ...]:
        """Axes with a distribution."""
        return tuple(axis for axis in self.cells.axes if axis.drawn)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each grid axis, then the draws."""
        return (*(axis.count for axis in self.grid_axes), self.cells.draws)

    def column(self, name: str) -> Array:
        """(*shape) numbers of a column, NaN where there are none (yet)."""
        found = np.full(self.cells.count, np.nan)
        values = self.table[name].to_pylist()
        found[self.table["cell"].to_numpy()] = [np.nan if v is None else float(v) for v in values]
        return found.reshape(self.shape)

    def counts(self, name: str) -> Counter[str]:
        """How often a column holds each text; empty ones do not count."""
        return Counter(text for text in self.table[name].to_pylist() if text)


def study_results(folder: Path) -> StudyResults:
    """Read a sweep's folder.

    Raises:
        SweepFolderError: the folder is no sweep's, holds nothing yet, or is damaged.
    """
    manifest = read_manifest(folder)
    try:
        config = StudyConfig.model_validate_json(json.dumps(manifest["study"]))
        scene, versions = str(manifest["scene"]), dict(manifest["versions"])
    except (ValidationError, KeyError, TypeError, ValueError) as error:
        mend = "sweep into a new folder"
        raise SweepFolderError("its study cannot be read", where=folder.name, mend=mend) from error
    axes = tuple(Axis(name, axis) for name, axis in config.axes.items())
    return StudyResults(
        config,
        scene,
        versions,
        CellSpace(axes, config.draws or 1, config.seed),
        read_results(folder),
        float(np.sum(read_timings(folder)["seconds"].to_numpy())),
    )
