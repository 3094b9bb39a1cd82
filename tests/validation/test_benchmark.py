"""The benchmark of the engines says what it measured, and what it could not."""

from __future__ import annotations

import sys

import pytest

from pivotgait.benchmarks.simulation import simulation_rows
from pivotgait.validation.simulator import SIMULATORS


@pytest.mark.slow
def test_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    rows = dict(zip(SIMULATORS, simulation_rows(quick=True), strict=True))
    bullet, missing = rows["pybullet"], rows["mujoco"]
    assert 0.0 < bullet["peer_s"] < bullet["ours_s"]
    assert bullet["real_time_factor"] == pytest.approx(1e-3 / bullet["ours_s"])
    assert bullet["ratio"] == pytest.approx(bullet["peer_s"] / bullet["ours_s"])
    assert missing["ours_s"] is None
    assert "pip install 'pivotgait[mujoco]'" in missing["name"]
