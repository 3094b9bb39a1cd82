"""The benchmark's row says what it measured."""

from pivotgait.benchmarks.control import control_rows


def test_row() -> None:
    (row,) = control_rows(quick=True)
    assert 0.0 < row["peer_s"] < row["ours_s"] < 5e-3
    assert row["ratio"] == row["peer_s"] / row["ours_s"]
