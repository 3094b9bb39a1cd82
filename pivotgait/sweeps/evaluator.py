"""From the numbers of cells to their outcomes, in this process."""

from __future__ import annotations

from collections.abc import Sequence

from pivotgait.sweeps.outcome import Columns, Computation, Outcome
from pivotgait.sweeps.scene_family import SceneFamily
from pivotgait.sweeps.static_grasps import STATIC_COLUMNS, StaticGrasps
from pivotgait.sweeps.study import Study
from pivotgait.sweeps.study_config import Compute, TrialsConfig
from pivotgait.sweeps.whole_gaits import (
    PLAN_COLUMNS,
    REMOVAL_COLUMNS,
    TRIAL_COLUMNS,
    Plans,
    Removals,
    Trials,
)

COLUMNS: dict[Compute, Columns] = {
    "static": STATIC_COLUMNS,
    "removal": REMOVAL_COLUMNS,
    "plan": PLAN_COLUMNS,
    "trials": TRIAL_COLUMNS,
}
"""Columns of the results of each computation."""


class Evaluator:
    """Computes a study's cells. An outcome depends on the study and the cell alone.

    Args:
        study: whose cells.
    """

    def __init__(self, study: Study) -> None:
        self._cells = study.cells
        self._computation = _computation(study)

    def outcomes(self, numbers: Sequence[int]) -> list[Outcome]:
        """Of the cells with these numbers, in their order."""
        return self._computation.outcomes([self._cells.cell(number) for number in numbers])


def _computation(study: Study) -> Computation:
    config = study.config
    family = SceneFamily(config, study.scene, study.folder)
    if config.compute == "static":
        return StaticGrasps(family, config.static.contacts if config.static else None)
    if config.compute == "removal":
        return Removals(family)
    plans = Plans(family, config.seed)
    if config.compute == "plan":
        return plans
    return Trials(plans, config.trials or TrialsConfig(), config.seed, study.folder)
