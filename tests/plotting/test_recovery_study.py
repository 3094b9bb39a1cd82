"""The figure of study 14: every trial has its place in a bar."""

from __future__ import annotations

import pytest

from pivotgait.plotting import figure_bytes
from pivotgait.plotting.recovery_study import recovery_study


@pytest.mark.parametrize("ways", [("without", "with"), ("without", "with", "cones")])
def test_bars_are_as_high_as_there_are_trials(ways: tuple[str, ...]) -> None:
    outcomes = {"passed": 3, "slip": 2, "put-back": 4, "collision": 1}
    figure = recovery_study({name: dict.fromkeys(ways, outcomes) for name in ("a", "b")})
    bars = figure.axes[0].patches
    assert sum(bar.get_height() for bar in bars) == 2 * len(ways) * sum(outcomes.values())
    assert max(bar.get_y() + bar.get_height() for bar in bars) == sum(outcomes.values())
    assert figure_bytes(figure, "png")
