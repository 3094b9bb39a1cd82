"""From a folder with a plan to its page and figures."""

import json
from dataclasses import replace

import pytest

from pivotgait.exceptions import InputError, PlanFileError
from pivotgait.plans import write_plan
from pivotgait.reporting import report_from_folder
from pivotgait.reporting.summary import PhaseSummary
from tests.plotting.knife_gait import knife_plan


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("knife")
    plan = knife_plan(certificate={"valid": True, "residuals": {}})
    # one phase has a figure of every kind
    addition = replace(plan.phases[2], name="00_addition")
    write_plan(replace(plan, phases=(addition,)), folder / "plan.h5")
    phases = [{"name": "00_addition", "plan_time_s": 0.0123}]
    (folder / "summary.json").write_text(json.dumps({"phases": phases}))
    report_from_folder(folder)
    return folder


def test_page_and_figures_are_there(folder):
    figures = {path.name for path in (folder / "figures").iterdir()}
    of_phase = (f"00_addition_{kind}" for kind in ("snapshots", "angles", "cone"))
    names = ("hero", "overview", *of_phase)
    assert figures == {f"{name}.{form}" for name in names for form in ("pdf", "png")}
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "Valid gait" in text
    assert "0.0123\N{NO-BREAK SPACE}s" in text


def test_page_is_small_enough_to_mail(folder):
    # a gait has about ten phases
    assert (folder / "report.html").stat().st_size < 600_000


def test_a_missing_plan_is_bad_input(tmp_path):
    with pytest.raises(PlanFileError, match=r"plan\.h5") as caught:
        report_from_folder(tmp_path)
    assert caught.value.exit_code == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "summary",
    [
        "{",
        "[]",
        '{"phases": 3}',
        '{"phases": [3]}',
        '{"phases": [{"name": "00_lift", "plan_time_s": "soon"}]}',
        '{"validations": 3}',
        '{"validations": [3]}',
        '{"validations": [{"simulator": "pybullet"}]}',
    ],
)
def test_a_broken_summary_is_bad_input_and_nothing_is_drawn(summary, plan, tmp_path):
    write_plan(plan, tmp_path / "plan.h5")
    (tmp_path / "summary.json").write_text(summary)
    with pytest.raises(InputError, match=r"summary\.json"):
        report_from_folder(tmp_path)
    assert not (tmp_path / "report.html").exists()
    assert not (tmp_path / "figures").exists()


def test_a_removal_is_reported_with_its_need_to_turn_and_its_optimality() -> None:
    found = {
        "name": "02_removal",
        "reorientation_deg": 9.34,
        "solver": "fatrop",
        "iterations": 21,
        "kkt_residual": 1e-8,
        "smallest_static_turn_deg": 9.3399,
        "static_without_turning": False,
    }
    note = PhaseSummary.model_validate(found).note
    for part in ("cannot hold", "9.34°", "fatrop", "21 iterations", "10⁻⁸"):
        assert part in note
    still = PhaseSummary.model_validate({**found, "static_without_turning": True}).note
    assert "could hold" in still
    assert PhaseSummary(name="00_lift").note == ""
