"""Perturbed trials with the same seeds in two engines: how often the verdicts agree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.validation.agreement import PASSED
from pivotgait.validation.trial import TrialResult
from pivotgait.validation.trials import TrialSet
from pivotgait.validation.wilson import wilson_interval


@dataclass(frozen=True, eq=False)
class TrialAgreement:
    """Trials of one plan with the same seeds in two engines.

    Attributes:
        sets: of trials, in each engine.
    """

    sets: tuple[TrialSet, TrialSet]

    def __post_init__(self) -> None:
        seeds = [[each.seed for each in trials.results] for trials in self.sets]
        if seeds[0] != seeds[1] or not seeds[0]:
            mend = "give both the same seeds"
            raise InputError("have other seeds, or none", where="trials", mend=mend)

    @property
    def simulators(self) -> tuple[str, str]:
        """Names."""
        one, two = (trials.options.run.simulator for trials in self.sets)
        return one, two

    @property
    def trials(self) -> int:
        """Number of seeds."""
        return len(self.sets[0].results)

    @property
    def crossed(self) -> dict[tuple[str, str], int]:
        """Number of seeds by what became of them in each engine: passed or class of failure."""
        pairs = zip(*(map(_outcome, trials.results) for trials in self.sets), strict=True)
        return dict(Counter(pairs))

    @property
    def same_verdict(self) -> int:
        """Seeds with which both engines passed or both failed."""
        return sum(
            count
            for (one, two), count in self.crossed.items()
            if (one == PASSED) == (two == PASSED)
        )

    @property
    def same_outcome(self) -> int:
        """Seeds with which both passed or both failed by the same class."""
        return sum(count for (one, two), count in self.crossed.items() if one == two)

    @property
    def kappa(self) -> float | None:
        """Cohen's kappa of passed or failed: agreement beyond chance, over what chance leaves.

        None where chance leaves nothing: if both engines passed (or failed) every trial.
        """
        rates = [trials.passed / self.trials for trials in self.sets]
        chance = rates[0] * rates[1] + (1.0 - rates[0]) * (1.0 - rates[1])
        if chance >= 1.0:
            return None
        return (self.same_verdict / self.trials - chance) / (1.0 - chance)

    @property
    def unlike_plans(self) -> tuple[int, ...]:
        """Seeds whose trials were planned otherwise in the two engines, or in one of them only.

        Plans hang on the seed alone; where a limit of time cut the search short on a busy
        machine, such a seed compares planning and not physics.
        """
        pairs = zip(*(trials.results for trials in self.sets), strict=True)
        return tuple(one.seed for one, two in pairs if not _same_plan(one, two))

    @property
    def metric_differences(self) -> Mapping[str, tuple[float, float]]:
        """By metric: median and largest difference over the seeds with which both ran."""
        both = [
            (one.metrics.as_json(), two.metrics.as_json())
            for one, two in zip(*(trials.results for trials in self.sets), strict=True)
            if one.metrics is not None and two.metrics is not None
        ]
        if not both:
            return {}
        found = {name: [abs(one[name] - two[name]) for one, two in both] for name in both[0][0]}
        return {name: (float(np.median(each)), max(each)) for name, each in found.items()}

    def as_json(self) -> dict[str, Any]:
        """Plain data: rates and agreement with Wilson's 95 % intervals, the crossed table."""
        return {
            "simulators": list(self.simulators),
            "trials": self.trials,
            "seeds": [each.seed for each in self.sets[0].results],
            "passed": [trials.passed for trials in self.sets],
            "wilson_95": [list(wilson_interval(t.passed, self.trials)) for t in self.sets],
            "same_verdict": self.same_verdict,
            "same_verdict_wilson_95": list(wilson_interval(self.same_verdict, self.trials)),
            "same_outcome": self.same_outcome,
            "kappa": self.kappa,
            "crossed": [
                {"outcomes": list(pair), "trials": count}
                for pair, count in sorted(self.crossed.items())
            ],
            "unlike_plans": list(self.unlike_plans),
            "metric_differences": {
                name: {"median": middle, "largest": most}
                for name, (middle, most) in self.metric_differences.items()
            },
            "differing": [
                {"seed": one.seed, "verdicts": [asdict(each.verdict) for each in (one, two)]}
                for one, two in zip(*(trials.results for trials in self.sets), strict=True)
                if _outcome(one) != _outcome(two)
            ],
        }


def _outcome(result: TrialResult) -> str:
    return PASSED if result.verdict.passed else result.verdict.failure


def _same_plan(one: TrialResult, two: TrialResult) -> bool:
    """Whether both were carried out by one plan, as far as both runs went, or both by none."""
    if one.planned is None or two.planned is None:
        return one.planned is two.planned
    rows = min(len(one.planned.phase), len(two.planned.phase))
    return all(
        np.array_equal(getattr(one.planned, name)[:rows], getattr(two.planned, name)[:rows])
        for name in ("phase", "orientation", "force", "normal")
    )
