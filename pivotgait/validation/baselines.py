"""The same trials under every control law, and without pivoting: what each part is worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pivotgait.plans import GaitPlan
from pivotgait.validation.trial import TrialOptions, TrialResult
from pivotgait.validation.trials import TIME_LIMIT_S, TrialSet, run_trials


@dataclass(frozen=True)
class Baseline:
    """A way to carry a plan out.

    Attributes:
        name: for tables.
        controller: name of the control law.
        pivoting: whether the removal pivots the tool.
    """

    name: str
    controller: str
    pivoting: bool = True

    def of(self, options: TrialOptions) -> TrialOptions:
        """Options of trials carried out this way, else as ``options``."""
        run = replace(options.run, controller=self.controller)
        return replace(options, run=run, pivoting=self.pivoting)


BASELINES = (
    Baseline("hybrid", "hybrid"),
    Baseline("feed-forward", "feedforward"),
    Baseline("admittance", "admittance"),
    Baseline("position", "position"),
    Baseline("hybrid, without pivoting", "hybrid", pivoting=False),
)
"""Ours first."""


def run_baselines(
    plan: GaitPlan,
    seeds: Sequence[int],
    options: TrialOptions | None = None,
    *,
    baselines: Sequence[Baseline] = BASELINES,
    folder: Path | None = None,
    workers: int | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    progress: Callable[[TrialResult], None] | None = None,
) -> Mapping[str, TrialSet]:
    """Try a plan with each seed in each way; arguments are those of :func:`run_trials`.

    Worlds, sensors and plans of a seed are the same in all ways.

    Raises:
        InputError: as :func:`run_trials`; a plan without a removal.
    """
    options = options or TrialOptions()
    return {
        each.name: run_trials(
            plan,
            seeds,
            each.of(options),
            folder=folder,
            workers=workers,
            time_limit_s=time_limit_s,
            progress=progress,
        )
        for each in baselines
    }
