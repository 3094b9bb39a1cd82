"""How well a number that is known before a trial tells its failure: ROC curves and their areas."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import rankdata

from pivotgait.frozen import Array

NO_RUN = ("plan", "timeout", "crash")
"""Failures of trials that nothing was simulated in, or not to its end."""


def roc(score: Array, failed: Array) -> tuple[Array, Array, float]:
    """ROC curve of low scores as a sign of failure, and the area under it.

    Args:
        score: (n,) margins.
        failed: (n,) 1 for a failed trial, else 0.

    Returns:
        False and true positive rates from (0, 0) to (1, 1), and the area: the chance that a failed
        trial has a lower margin than a passed one, ties counting half; NaN without both kinds.
    """
    bad, good = float(failed.sum()), float(len(failed) - failed.sum())
    if not (bad and good):
        return np.array([0.0, 1.0]), np.array([0.0, 1.0]), float("nan")
    levels = np.unique(score)
    true = np.array([0.0, *[np.sum(failed[score <= level]) / bad for level in levels]])
    false = np.array([0.0, *[np.sum(1.0 - failed[score <= level]) / good for level in levels]])
    rank = float(np.sum(rankdata(-score)[failed == 1.0]))
    return false, true, (rank - bad * (bad + 1.0) / 2.0) / (bad * good)


def roc_interval(
    score: Array, failed: Array, rng: np.random.Generator, *, draws: int = 1000
) -> tuple[float, float]:
    """95 % interval of the ROC area by resampling the trials; NaN without both kinds."""
    picks = rng.integers(0, len(score), size=(draws, len(score)))
    areas = np.array([roc(score[pick], failed[pick])[2] for pick in picks])
    known = areas[np.isfinite(areas)]
    if not known.size:
        return float("nan"), float("nan")
    low, high = np.quantile(known, (0.025, 0.975)).tolist()
    return low, high


def chance(score: Array, failed: Array, rng: np.random.Generator, *, draws: int = 10_000) -> float:
    """Share of shuffled outcomes whose ROC area is at least as large; NaN without both kinds.

    The p-value of a permutation test that the score says nothing about failure; the outcomes as
    they are count as one of the shuffles, so that it is never zero.
    """
    bad, good = float(failed.sum()), float(len(failed) - failed.sum())
    if not (bad and good):
        return float("nan")
    ranks = rankdata(-score)
    picks = np.argsort(rng.random((draws, len(score))), axis=1)[:, : int(bad)]
    # the area grows with the sum of the failed trials' ranks
    shuffled = ranks[picks].sum(axis=1)
    least = float(ranks[failed == 1.0].sum())
    return (1.0 + float(np.sum(shuffled >= least - 1e-9))) / (1.0 + draws)


MARGINS = ("margin", "held_margin", "sensed_margin_N")
"""Of a trial, see ``trial_margins.py``."""
QUANTITIES = {
    "finger_friction_scale": 1,
    "table_friction_scale": 1,
    "mass_scale": -1,
    "offset_m": -1,
    "sensing_gain_error": -1,
    "sensing_angle_deg": -1,
    "errors_size": -1,
}
"""Single quantities of a draw, each with the sign with which one would guess failures from it."""


def prediction(rows: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """ROC area, its interval and its chance without any bearing, of margins and quantities."""
    run = [each for each in rows if each["failure"] not in NO_RUN]
    failed = np.array([0.0 if each["passed"] else 1.0 for each in run])
    found = {}
    for name, sign in (dict.fromkeys(MARGINS, 1) | QUANTITIES).items():
        score: Array = sign * np.array([each[name] for each in run], dtype=float)
        false, true, area = roc(score, failed)
        interval = roc_interval(score, failed, np.random.default_rng(0)) if run else (np.nan,) * 2
        found[name] = {
            "area": area,
            "interval_95": list(interval),
            "p_value": chance(score, failed, np.random.default_rng(0)),
            "false": false.tolist(),
            "true": true.tolist(),
        }
    return found
