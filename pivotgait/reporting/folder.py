"""The report of a folder that holds a plan."""

from __future__ import annotations

from pathlib import Path

from pivotgait.exceptions import InputError
from pivotgait.plans import read_plan
from pivotgait.reporting.figures import draw_figures
from pivotgait.reporting.page import write_report
from pivotgait.reporting.summary import read_summary

VIEW = "view.html"
"""The animated scene as ``pivotgait run`` leaves it beside the plan."""


def report_from_folder(folder: Path) -> Path:
    """Draw the figures of ``folder/plan.h5`` and write ``report.html`` beside it.

    ``figures/`` gets each figure as PDF and PNG. ``summary.json``, if there is one, is what
    ``pivotgait plan --json`` printed (its planning times are shown), with the records of
    ``pivotgait validate --json`` under ``validations``.

    A ``view.html`` in the folder is linked.

    Returns:
        Path of the page.

    Raises:
        PlanFileError: if there is no plan, or it is damaged.
        InputError: if the summary cannot be read, or the folder not be written.
    """
    plan = read_plan(folder / "plan.h5")
    summary = read_summary(folder / "summary.json")
    try:
        figures = draw_figures(plan, folder / "figures")
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", where=str(folder), mend="check the folder"
        ) from error
    return write_report(
        folder,
        plan,
        plan.certificate,
        figures,
        plan_times=summary.plan_times,
        notes=summary.notes,
        validations=summary.validations,
        view=VIEW if (folder / VIEW).is_file() else "",
    )
