"""What the report says of two engines, and that it says nothing without."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from pivotgait.exceptions import InputError
from pivotgait.plans import write_plan
from pivotgait.reporting import Picture, render_report
from pivotgait.reporting.comparison import engine_comparison
from pivotgait.reporting.folder import report_from_folder
from pivotgait.validation import (
    CompareOptions,
    Comparison,
    Metrics,
    RecordError,
    TrialOptions,
    TrialResult,
    TrialSet,
    Verdict,
    compare_runs,
    plan_digest,
)
from pivotgait.validation.agreement_causes import look_for_cause
from pivotgait.validation.agreement_trials import TrialAgreement
from pivotgait.validation.comparing import CarriedOut
from pivotgait.validation.comparison_files import write_comparison
from pivotgait.validation.run import RunOptions, SimulatorOptions

PASSED, SLIP = Verdict(True), Verdict(False, "slip", "x")


class _Fingers:
    """Of a robot as much as a comparison needs, which is nothing: slips are replaced."""


def words(text):
    plain = re.sub(r"<[^>]+>", " ", text.replace("\N{NO-BREAK SPACE}", " "))
    return " ".join(plain.split())


@pytest.fixture
def found(robot_plan, motion, monkeypatch):
    """Both engines 1.5 mm apart, with causes and trials."""
    monkeypatch.setattr(
        "pivotgait.validation.run_differences.fingertip_slips",
        lambda robot, series, planned: motion.fingertip_slips,
    )
    up = np.array([0.0, 0.0, 1.5e-3])
    raised = replace(motion.series, tool_position=motion.series.tool_position + up)
    pair = (
        CarriedOut("pybullet", motion.series, PASSED),
        CarriedOut("mujoco", raised, PASSED),
    )
    agreement = compare_runs(robot_plan, _Fingers(), *pair)
    causes = look_for_cause(agreement, SimulatorOptions(), lambda _: agreement)
    metrics = Metrics(0.04, 0.3, 1.5, 0.31, 0.5, 0.4)
    results = [TrialResult(0, PASSED, metrics, each.series, motion.planned) for each in pair]
    sets = [
        TrialSet(
            TrialOptions(RunOptions(simulator=each.simulator)),
            (),
            (TrialResult(0, PASSED), TrialResult(1, last)),
        )
        for each, last in zip(pair, (PASSED, SLIP), strict=True)
    ]
    trials = TrialAgreement((sets[0], sets[1]))
    return Comparison(plan_digest(robot_plan), tuple(results), agreement, causes, trials)


def test_the_page_tells_score_gap_causes_and_trials(found, robot_plan, certificate, figures):
    engines = engine_comparison(found.as_json(), where="comparison.json")
    assert not engines.agrees
    figures |= {"comparison": Picture(b"\x89PNG", alt="both", caption="Both.", engines=True)}
    page = render_report(robot_plan, certificate, figures, engines=engines)
    text = words(page)
    assert "PyBullet and MuJoCo" in text
    assert "position of the tool" in text
    assert "1.5 mm, 1.5 of its tolerance" in text
    assert "None of the changes that were tried" in text
    assert "step halved" in text
    assert "PyBullet passed 2 of 2" in text
    assert "MuJoCo passed 1 of 2" in text
    assert "verdicts agree on 1 (95 % confidence 9.5 to 90.5 %)" in text
    assert text.count("Both.") == 1
    assert len(engines.rows) == len(found.agreement.phases)
    beyond = {cell.head for row in engines.rows for cell in row.cells if not cell.within}
    assert beyond == {"position of the tool"}


def test_without_a_comparison_the_page_does_not_name_it(robot_plan, certificate, figures):
    assert "MuJoCo" not in render_report(robot_plan, certificate, figures)


def test_names_are_escaped(found, robot_plan, certificate, figures):
    told = json.loads(json.dumps(found.as_json()).replace('"step halved"', '"<b>step</b>"'))
    engines = engine_comparison(told, where="comparison.json")
    page = render_report(robot_plan, certificate, figures, engines=engines)
    assert "<b>step</b>" not in page
    assert "&lt;b&gt;step" in page


@pytest.mark.parametrize(
    "damage",
    [
        lambda told: told.pop("nominal"),
        lambda told: told["nominal"].pop("tolerances"),
        lambda told: told["nominal"]["tolerances"].pop("timing_ms"),
        lambda told: told["nominal"]["phases"][0].update(position_mm="far"),
        lambda told: told["nominal"]["largest_gap"].update(quantity="beauty"),
        lambda told: told["trials"].update(passed=3),
    ],
)
def test_what_says_too_little_is_refused(found, damage):
    told = json.loads(json.dumps(found.as_json()))
    damage(told)
    with pytest.raises(InputError, match=r"comparison\.json") as caught:
        engine_comparison(told, where="comparison.json")
    assert caught.value.exit_code == 2


@pytest.fixture
def folder(found, robot_plan, tmp_path, monkeypatch):
    """Of a plan and its comparison; only the comparison's figure is drawn."""
    monkeypatch.setattr("pivotgait.reporting.folder.draw_figures", lambda plan, folder: {})
    write_plan(robot_plan, tmp_path / "plan.h5")
    write_comparison(found, robot_plan, CompareOptions(), tmp_path)
    return tmp_path


def test_a_folder_with_another_plans_comparison_is_refused(folder, robot_plan):
    write_plan(replace(robot_plan, seed=robot_plan.seed + 1), folder / "plan.h5")
    with pytest.raises(RecordError, match="another plan"):
        report_from_folder(folder)
    assert not (folder / "report.html").exists()
