"""The report of a folder that holds a plan."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plans import GaitPlan, read_plan
from pivotgait.reporting.comparison import engine_comparison
from pivotgait.reporting.comparison_figure import draw_comparison
from pivotgait.reporting.figures import draw_figures
from pivotgait.reporting.page import write_report
from pivotgait.reporting.plan_document import plan_pdf
from pivotgait.reporting.report_files import FIGURES, PDF, Report
from pivotgait.reporting.run_figures import draw_run_figures
from pivotgait.reporting.summary import Trials, read_summary, trials_of
from pivotgait.validation import read_summary as read_record_summary
from pivotgait.validation.comparison_files import FOUND, RecordedComparison, read_comparison
from pivotgait.validation.record_reading import RecordedRun, read_run

VIEW, RUN_VIEW = "view.html", "run_view.html"
"""The animated scenes of the plan and of its run as ``pivotgait run`` leaves them beside it."""
RECORD, TRIALS = "record.h5", "trials.h5"
"""Records of the nominal run and of perturbed trials, likewise."""
_OURS = re.compile(
    r"hero|overview|robot_scene|joint_(positions|speeds|torques)|\d\d_\w+_(snapshots|angles|cone)|"
    r"run_(strip|normal_forces|angles|deviations|torques)|comparison"
)
"""Names of the figures that a report may hold."""


def report_from_folder(folder: Path) -> Report:
    """Draw the figures of ``folder/plan.h5``, write ``report.html`` and ``report.pdf`` beside it.

    ``figures/`` gets each figure as PDF and PNG, and loses those of an earlier report.
    ``summary.json``, if there is one, is what ``pivotgait plan --json`` printed (its planning
    times are shown), with the records of ``pivotgait validate --json`` under ``validations``.
    ``record.h5`` is the plan's nominal run and ``trials.h5`` are perturbed trials, as
    ``pivotgait validate -o`` writes them; ``comparison.json`` with its records is what
    ``pivotgait compare -o`` writes. Animated scenes in the folder are linked.

    Returns:
        Paths of the page and of the PDF.

    Raises:
        PlanFileError: if there is no plan, or it is damaged.
        RecordError: if a record is damaged, or of another plan.
        InputError: if the summary cannot be read, or the folder not be written.
    """
    plan = read_plan(folder / "plan.h5")
    summary = read_summary(folder / "summary.json")
    run, trials = _run(folder, plan), _trials(folder, plan)
    compared = _compared(folder, plan)
    engines = engine_comparison(compared.found, where=FOUND) if compared else None
    told: dict[str, Any] = {
        "plan_times": summary.plan_times,
        "notes": summary.notes,
        "run": run,
        "validations": (*trials, *summary.validations),
        "engines": engines,
    }
    try:
        figures = draw_figures(plan, folder / FIGURES)
        if run:
            figures |= draw_run_figures(plan, run, folder / FIGURES)
        if compared:
            figures |= draw_comparison(plan, compared, folder / FIGURES)
        _remove_others(folder / FIGURES, figures)
        pdf = plan_pdf(plan, plan.certificate, figures, folder / FIGURES, **told)
        write_atomically(pdf, folder / PDF)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", where=str(folder), mend="check the folder"
        ) from error
    page = write_report(
        folder,
        plan,
        plan.certificate,
        figures,
        **told,
        view=VIEW if (folder / VIEW).is_file() else "",
        run_view=RUN_VIEW if run and (folder / RUN_VIEW).is_file() else "",
    )
    return Report(page, folder / PDF)


def _run(folder: Path, plan: GaitPlan) -> RecordedRun | None:
    path = folder / RECORD
    return read_run(path, plan) if path.exists() else None


def _compared(folder: Path, plan: GaitPlan) -> RecordedComparison | None:
    return read_comparison(folder, plan) if (folder / FOUND).exists() else None


def _trials(folder: Path, plan: GaitPlan) -> tuple[Trials, ...]:
    path = folder / TRIALS
    if not path.exists():
        return ()
    return (trials_of(read_record_summary(path, plan), where=path.name),)


def _remove_others(folder: Path, names: Iterable[str]) -> None:
    """Remove figures of an earlier report that this one has not drawn; other files stay."""
    kept = set(names)
    for path in folder.iterdir():
        drawn = path.suffix in (".pdf", ".png") and _OURS.fullmatch(path.stem)
        if drawn and path.stem not in kept:
            path.unlink()
