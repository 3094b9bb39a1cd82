"""The benchmark's own parts: the engines' clock, and rows with and without the peer."""

import sys

import pinocchio as pin
import pytest

from pivotgait.benchmarks.relocation import (
    ENGINE_CALLS,
    TIME_LIMIT_S,
    Grip,
    Task,
    engine_time,
    relocation_rows,
)
from pivotgait.planning.problem import RelocationProblem


def test_the_clock_counts_engine_calls_and_leaves_them_as_they_were(grip: Grip) -> None:
    plain = {name: getattr(pin, name) for name in ENGINE_CALLS}
    with engine_time() as spent:
        assert spent() == 0.0
        grip.world.free(grip.q, *grip.tool.pose(0.0))
        assert 0.0 < spent() < 1.0
    assert all(getattr(pin, name) is call for name, call in plain.items())


def test_search_is_mostly_engine_time(first_contact: RelocationProblem) -> None:
    task = Task(first_contact)
    with engine_time() as spent:
        whole = sum(task.ours(seed) for seed in range(5))
        share = spent() / whole
    assert share > 0.4  # about 0.65 on an idle machine


def test_rows_without_the_peer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ompl", None)
    rows = relocation_rows(quick=True)
    assert len(rows) == 4
    for row in rows[:-1]:
        assert row["solved"] == 1.0
        assert 0.0 < row["ours_s"] < TIME_LIMIT_S
        assert "not installed" in row["peer"]
        assert row["peer_s"] is None
        assert row["ratio"] is None
    assert 0.2 < rows[-1]["engine_share"] < 1.0


@pytest.mark.slow
def test_the_peer_solves_the_same_problem(first_contact: RelocationProblem) -> None:
    pytest.importorskip("ompl")
    assert 0.0 < Task(first_contact).ompl(0) <= TIME_LIMIT_S
