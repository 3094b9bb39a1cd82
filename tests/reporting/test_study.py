"""The report of a sweep: finished or not, it says what the results say."""

from __future__ import annotations

from pathlib import Path

import pytest

from pivotgait.exceptions import InputError
from pivotgait.reporting import report_from_sweep
from pivotgait.reporting.study_figures import axis_shares, study_figures
from pivotgait.reporting.study_rows import study_tables
from pivotgait.sweeps import parse_study, run_sweep
from pivotgait.sweeps.study_results import study_results
from tests.reporting.test_page import Page
from tests.sweeps.cases import DRAWN, GRID

TEXTS = {
    "grid": GRID,
    "drawn": DRAWN,
    "some invalid": GRID.replace("from: 0.1, to: 0.9", "from: -0.1, to: 0.9"),
}

LINE = "axes:\n  contacts.*.friction: {linspace: {from: 0.1, to: 0.9, count: 520}}\n"


@pytest.fixture(scope="module", params=TEXTS)
def folder(request, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sweep")
    run_sweep(parse_study(TEXTS[request.param]), folder, workers=1)
    report_from_sweep(folder)
    return folder


def test_the_page_needs_nothing_else_and_says_the_counts(folder):
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    results = study_results(folder)
    table = results.table
    held = sum(bool(each) for each in table["feasible"].to_pylist())
    known = sum(each is not None for each in table["feasible"].to_pylist())
    assert f"{held} of {known} cells feasible" in page.text
    assert "Methods" in page.text
    assert f"{results.rows} of {results.cells.count} cells are done" in page.text
    assert all(each["src"].startswith("data:") for each in page.tags("img"))
    assert not page.tags("script")
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")


def test_shares_along_each_axis_add_up(folder):
    results = study_results(folder)
    known = sum(each is not None for each in results.table["feasible"].to_pylist())
    shares = list(axis_shares(results))
    assert shares
    for each in shares:
        assert each.count.sum() == known
        assert each.feasible.sum() == sum(filter(None, results.table["feasible"].to_pylist()))
        low, high = each.interval.T
        share = each.feasible / each.count.clip(1)
        assert ((low <= share + 1e-12) & (share <= high + 1e-12)).all()


def test_tables_are_rectangular_and_binding_limits_are_counted(folder):
    results = study_results(folder)
    tables = {each.title: each for each in study_tables(results)}
    for each in tables.values():
        assert {len(row) for row in each.rows} <= {len(each.head)}
    binding = tables["The limit that binds, or comes nearest"]
    counted = sum(int(row[1]) + int(row[2]) for row in binding.rows)
    assert counted == sum(each is not None for each in results.table["feasible"].to_pylist())


def test_a_sweep_that_is_not_finished_says_so_every_time_in_the_same_bytes(tmp_path):
    text = GRID[: GRID.index("axes:")] + LINE
    run_sweep(parse_study(text), tmp_path, workers=1)
    last = sorted((tmp_path / "parts").iterdir())[-1]
    missing = study_results(tmp_path)
    last.unlink()
    results = study_results(tmp_path)
    assert results.rows < missing.rows == results.cells.count
    page = Page(report_from_sweep(tmp_path).page.read_text(encoding="utf-8"))
    assert f"{results.cells.count - results.rows} cells are missing" in page.text
    before = (tmp_path / "report.pdf").read_bytes()
    assert report_from_sweep(tmp_path).pdf.read_bytes() == before


def test_every_figure_has_its_own_name_and_words(folder):
    figures = list(study_figures(study_results(folder)))
    assert len({each.name for each in figures}) == len(figures) > 0
    assert all(each.alt and each.caption.endswith(".") for each in figures)


def test_no_sweep_is_bad_input(tmp_path):
    with pytest.raises(InputError, match="sweep"):
        report_from_sweep(tmp_path)
