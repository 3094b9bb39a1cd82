"""Where a report is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

PAGE, PDF, FIGURES = "report.html", "report.pdf", "figures"
"""Names of the page, of the same as PDF, and of the folder of its figures."""


@dataclass(frozen=True)
class Report:
    """The files of a report.

    Attributes:
        page: the HTML file.
        pdf: the same as PDF.
    """

    page: Path
    pdf: Path
