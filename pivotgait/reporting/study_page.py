"""The report of a sweep's folder: one page and one PDF, readable without the code."""

from __future__ import annotations

from pathlib import Path

from pivotgait import plotting
from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.plotting.document import (
    Block,
    Heading,
    Paragraph,
    PictureBlock,
    TableBlock,
    document_pdf,
)
from pivotgait.reporting.page import Picture
from pivotgait.reporting.rendering import render
from pivotgait.reporting.report_files import FIGURES, PAGE, PDF, Report
from pivotgait.reporting.study_figures import StudyFigure, study_figures
from pivotgait.reporting.study_methods import methods
from pivotgait.reporting.study_rows import Table, headline, study_tables
from pivotgait.sweeps.study_results import StudyResults, study_results

_PICTURE_DPI = 220


def report_from_sweep(folder: Path) -> Report:
    """Draw a sweep's figures, finished or not, and write ``report.html`` and ``report.pdf``.

    ``figures/`` gets each figure as PDF and PNG.

    Raises:
        SweepFolderError: the folder is no sweep's, holds nothing yet, or is damaged.
        InputError: the folder cannot be written.
    """
    results = study_results(folder)
    figures = list(study_figures(results))
    tables = list(study_tables(results))
    report = Report(folder / PAGE, folder / PDF)
    try:
        for each in figures:
            plotting.save_figure(each.figure, folder / FIGURES, each.name)
        write_atomically(_page(results, figures, tables).encode(), report.page)
        write_atomically(_pdf(results, figures, tables), report.pdf)
    except OSError as error:
        what, mend = f"cannot be written: {error.strerror}", "check the folder"
        raise InputError(what, where=str(folder)[:80], mend=mend) from error
    return report


def _page(results: StudyResults, figures: list[StudyFigure], tables: list[Table]) -> str:
    pictures = [
        Picture(plotting.figure_bytes(each.figure, "svg"), each.alt, each.caption)
        for each in figures
    ]
    return render(
        "study.html.j2",
        config=results.config,
        headline=headline(results),
        complete=results.rows == results.cells.count,
        missing=results.cells.count - results.rows,
        pictures=pictures,
        tables=tables,
        methods=methods(results),
        study=_study_text(results),
        scene=results.scene,
        versions=results.versions,
    )


def _pdf(results: StudyResults, figures: list[StudyFigure], tables: list[Table]) -> bytes:
    config = results.config
    blocks: list[Block] = [
        Heading(f"{config.name}: {headline(results)}", 1),
        Paragraph(config.description or f"A sweep of the scene {config.scene}."),
    ]
    for each in figures:
        png = plotting.figure_bytes(each.figure, "png", dpi=_PICTURE_DPI)
        blocks.append(PictureBlock(png, each.caption, dpi=_PICTURE_DPI))
    for table in tables:
        blocks += [Heading(table.title), TableBlock(table.head, table.rows)]
    blocks += [Heading("Methods"), *(Paragraph(text) for text in methods(results))]
    versions = ", ".join(f"{name} {each}" for name, each in sorted(results.versions.items()))
    blocks += [Heading("Versions"), Paragraph(versions)]
    blocks += [Heading("Study"), Paragraph(_study_text(results), fixed=True)]
    blocks += [Heading("Scene"), Paragraph(results.scene, fixed=True)]
    return document_pdf(blocks, title=f"{config.name}: {headline(results)}")


def _study_text(results: StudyResults) -> str:
    """The study's fields as YAML, those that are given."""
    from io import StringIO

    from ruamel.yaml import YAML

    given = results.config.model_dump(mode="json", by_alias=True, exclude_none=True)
    writer, text = YAML(), StringIO()
    writer.width = 96
    writer.dump(given, text)
    return text.getvalue()
