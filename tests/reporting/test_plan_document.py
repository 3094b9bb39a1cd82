"""The report of a plan as PDF: it says what the page says, and is the same bytes every time."""

from dataclasses import replace

import pytest

from pivotgait.plotting.document import Heading, Paragraph, PictureBlock, TableBlock
from pivotgait.reporting import Picture, Trials, plan_document
from pivotgait.reporting.rows import phase_rows
from pivotgait.validation import Verdict

TRIALS = {
    "simulator": "pybullet", "controller": "hybrid", "trials": 10, "passed": 7, "rate": 0.7,
    "wilson_95": [0.4, 0.89], "stages": [{"name": "00_lift", "reached": 10, "passed": 7}],
    "failures": {"slip": 2, "roll-out": 1},
}  # fmt: skip


@pytest.fixture
def folder(figures, dot, tmp_path):
    """With the PNG of every figure."""
    for name in (*figures, "run_strip"):
        (tmp_path / f"{name}.png").write_bytes(dot)
    return tmp_path


@pytest.fixture
def blocks(monkeypatch):
    """What a document is made of, instead of its bytes."""

    def caught(*given, **more):
        monkeypatch.setattr(plan_document, "document_pdf", lambda blocks, title: blocks)
        return plan_document.plan_pdf(*given, **more)

    return caught


def said(blocks):
    """All text of a document, cells of a table side by side."""
    text = []
    for each in blocks:
        if isinstance(each, TableBlock):
            text += ["  ".join(row) for row in (each.head, *each.rows)]
        else:
            text.append(each.caption if isinstance(each, PictureBlock) else each.text)
    return "\n".join(text).replace("\N{NO-BREAK SPACE}", " ")


def test_phases_and_checks_are_told(plan, certificate, figures, folder, blocks):
    notes = {"00_lift": "It was easy."}
    found = blocks(plan, certificate, figures, folder, plan_times={"00_lift": 0.25}, notes=notes)
    text = said(found)
    for row in phase_rows(plan, {"00_lift": 0.25}):
        assert f"{row.name}  {row.finger}".replace("\N{NO-BREAK SPACE}", " ") in text
    for told in ("Valid gait", "It was easy.", "0.25 s", "Certificate: 2 checks", "0.012 N",
                 f"seed {plan.seed}", plan.scene.splitlines()[0]):  # fmt: skip
        assert told in text
    assert "Closed loop" not in text
    assert "Arm and hand" not in text
    assert sum(isinstance(each, PictureBlock) for each in found) == len(figures)


def test_a_run_its_trials_and_the_hand_are_told(
    robot_plan, certificate, figures, folder, run, blocks
):
    figures |= {"run_strip": Picture(b"\x89PNG", alt="the run", caption="It ran.", run=True)}
    trials = [Trials.model_validate(TRIALS)]
    text = said(blocks(robot_plan, certificate, figures, folder, run=run, validations=trials))
    for told in ("carried out in PyBullet", "≤ 0.25 N", "It ran.", "7 of 10 passed",
                 "0.4 to 0.89", "slip 2, roll-out 1", "Arm and hand"):  # fmt: skip
        assert told in text
    assert text.count("It ran.") == 1


def test_what_fails_comes_first(robot_plan, certificate, figures, folder, run, blocks):
    failed = replace(run, verdict=Verdict(False, "slip", "03_removal", 3.25, "thumb slipped"))
    violation = {"what": "force_balance_n", "value": 1.0, "limit": 1e-6, "phase": "00_lift"}
    broken = certificate | {"valid": False, "violations": [violation]}
    found = blocks(robot_plan, broken, figures, folder, run=failed)
    assert "Not a valid gait, and its run in PyBullet failed" in found[0].text
    assert "Violations (1)" in [each.text for each in found if isinstance(each, Heading)]
    assert any("thumb slipped" in each.text for each in found if isinstance(each, Paragraph))


def test_the_same_plan_gives_the_same_bytes(plan, certificate, figures, folder):
    one, other = (plan_document.plan_pdf(plan, certificate, figures, folder) for _ in range(2))
    assert one == other
    assert one.startswith(b"%PDF")


def test_a_missing_figure_is_not_passed_over(plan, certificate, figures, tmp_path):
    with pytest.raises(OSError, match="hero"):
        plan_document.plan_pdf(plan, certificate, figures, tmp_path)
