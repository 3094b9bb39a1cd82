"""What the report says of a closed-loop run and of trials, and that it says nothing without."""

import json
import re
from dataclasses import replace

import pytest

from pivotgait import plotting
from pivotgait.exceptions import InputError
from pivotgait.plans import write_plan
from pivotgait.reporting import Picture, Trials, folder, render_report, verdict
from pivotgait.reporting.folder import report_from_folder
from pivotgait.reporting.run_figures import draw_run_figures
from pivotgait.reporting.run_rows import run_rows
from pivotgait.reporting.summary import trials_of
from pivotgait.validation import (
    RecordError,
    Stage,
    TrialOptions,
    TrialResult,
    TrialSet,
    Verdict,
    write_record,
)

FAILED = Verdict(False, "slip", "03_removal", 3.25, "thumb slipped <3> mm")
TRIALS = {
    "simulator": "pybullet", "controller": "hybrid", "trials": 10, "passed": 7, "rate": 0.7,
    "wilson_95": [0.4, 0.89], "stages": [{"name": "00_lift", "reached": 10, "passed": 7}],
    "failures": {"slip": 2, "roll-out": 1},
}  # fmt: skip


def words(text):
    plain = re.sub(r"<[^>]+>", " ", text.replace("\N{NO-BREAK SPACE}", " "))
    return " ".join(plain.split())


def test_the_headline_says_both(certificate, run):
    found = verdict(certificate, run)
    assert found.state == "valid"
    assert found.headline == "Valid gait, carried out in PyBullet"
    assert found.sentence.startswith(verdict(certificate).sentence)


def test_a_failed_run_is_the_verdict(certificate, run):
    found = verdict(certificate, replace(run, verdict=FAILED))
    assert found.state == "invalid"
    assert found.headline == "Valid gait, but its run in PyBullet failed"
    assert words(found.sentence).endswith(
        "failed by slip in 03_removal after 3.25 s: thumb slipped mm."
    )


def test_a_run_does_not_mend_a_certificate(certificate, run):
    assert verdict({**certificate, "valid": False}, run).state == "invalid"
    assert verdict(None, run).state == "unknown"
    assert "and its run" in verdict(None, replace(run, verdict=FAILED)).headline


def test_a_trial_that_never_ran_says_why(certificate, run):
    crash = Verdict(False, "crash", detail="the process ended with -11")
    found = verdict(certificate, replace(run, verdict=crash, metrics=None, motion=None))
    assert "failed by crash: the process ended with -11." in found.sentence


def test_figures_stand_beside_aim_and_limit(run):
    rows = {row.meaning.split(",")[0]: row for row in run_rows(run)}
    turn, finger = rows["Orientation"], rows["Slip of a fingertip on the tool"]
    assert (turn.value, turn.aim, turn.limit, turn.within) == ("1.5°", "≤ 2.5°", "≤ 5°", True)
    assert not finger.within
    assert [row.within for row in run_rows(run)] == [True, False, True, True, False, True]
    assert run_rows(None) == run_rows(replace(run, metrics=None)) == ()


def test_the_page_tells_the_run_right_after_the_picture(robot_plan, certificate, figures, run):
    figures |= {"run_strip": Picture(b"\x89PNG", alt="the run", caption="It ran.", run=True)}
    trials = Trials.model_validate(TRIALS)
    page = render_report(
        robot_plan, certificate, figures, run=run, validations=[trials], run_view="run_view.html"
    )
    places = [page.index(f'id="{name}"') for name in ("closed-loop", "phases")]
    assert places == sorted(places)
    section = words(page[places[0] : places[1]])
    for said in ("0.04 N", "≤ 0.25 N", "beyond its aim", "It ran.", "7 of 10 passed",
                 "0.4 to 0.89", "slip 2, roll-out 1", "See the run move"):  # fmt: skip
        assert said in section
    assert page.count("It ran.") == 1


def test_the_page_of_a_failure_escapes_its_reason(robot_plan, certificate, figures, run):
    page = render_report(robot_plan, certificate, figures, run=replace(run, verdict=FAILED))
    assert "thumb slipped &lt;3&gt; mm" in page
    assert "<3>" not in page


def test_without_run_and_trials_there_is_no_section(plan, certificate, figures):
    assert "Closed loop" not in render_report(plan, certificate, figures)


def test_every_figure_of_a_run_is_saved(robot_plan, run, tmp_path, monkeypatch):
    # the strip has its own tests; saving it takes seconds
    monkeypatch.setattr(
        plotting, "run_strip", lambda plan, motion, **_: plotting.run_deviations(plan, motion)
    )
    pictures = draw_run_figures(robot_plan, run, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {
        f"{name}.{form}" for name in pictures for form in ("pdf", "png")
    }
    assert all(picture.run for picture in pictures.values())
    assert all(folder._OURS.fullmatch(name) for name in pictures)
    assert draw_run_figures(robot_plan, replace(run, motion=None), tmp_path) == {}


@pytest.fixture
def cheap(monkeypatch, figures, dot):
    """A folder's report without the drawing of its plan."""

    def draw(_, where):
        where.mkdir(exist_ok=True)
        for name in figures:
            (where / f"{name}.png").write_bytes(dot)
        return figures

    monkeypatch.setattr(folder, "draw_figures", draw)


def record(plan, path, result, *, perturbed=False, stages=()):
    write_record(TrialSet(TrialOptions(perturbed=perturbed), stages, (result,)), plan, path)


def test_old_figures_go_and_other_files_stay(cheap, dot, plan, tmp_path):
    write_plan(plan, tmp_path / "plan.h5")
    kept = {"notes.txt", "mine.png", "hero.png", "hero.svg"}
    gone = {"07_addition_cone.pdf", "run_strip.png", "joint_speeds.pdf", "01_lift_angles.png"}
    (tmp_path / "figures").mkdir()
    for name in kept | gone:
        (tmp_path / "figures" / name).write_bytes(b"old")
    report_from_folder(tmp_path)
    there = {path.name for path in (tmp_path / "figures").iterdir()}
    assert kept <= there
    assert not gone & there
    assert (tmp_path / "figures" / "hero.png").read_bytes() == dot


def test_records_in_the_folder_are_reported(cheap, plan, tmp_path):
    write_plan(plan, tmp_path / "plan.h5")
    crash = TrialResult(0, Verdict(False, "crash", detail="the process ended with -11"))
    record(plan, tmp_path / "record.h5", crash)
    stages = (Stage("00_lift", 1, 1),)
    record(plan, tmp_path / "trials.h5", crash, perturbed=True, stages=stages)
    text = words(report_from_folder(tmp_path).page.read_text(encoding="utf-8"))
    assert "its run in PyBullet failed" in text
    assert "the process ended with -11" in text
    assert "0 of 1 passed" in text
    assert "Failures: crash 1." in text


@pytest.mark.parametrize("name", ["record.h5", "trials.h5"])
@pytest.mark.parametrize("damage", ["another plan", "damaged"])
def test_a_wrong_record_is_bad_input_and_nothing_is_drawn(cheap, plan, tmp_path, name, damage):
    write_plan(plan, tmp_path / "plan.h5")
    if damage == "damaged":
        (tmp_path / name).write_bytes(b"no HDF5")
    else:
        crash = TrialResult(0, Verdict(False, "crash"))
        record(replace(plan, seed=9), tmp_path / name, crash, perturbed=name == "trials.h5")
    with pytest.raises(RecordError, match=rf"{name}.*{damage}") as caught:
        report_from_folder(tmp_path)
    assert caught.value.exit_code == 2
    assert not (tmp_path / "figures").exists()


def test_trials_that_say_too_little_are_bad_input():
    with pytest.raises(InputError, match=r"trials\.h5"):
        trials_of({**TRIALS, "passed": "many"}, where="trials.h5")
    assert trials_of(json.loads(json.dumps(TRIALS)), where="trials.h5").failures["slip"] == 2
