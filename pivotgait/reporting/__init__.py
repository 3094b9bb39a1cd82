"""A gait as one self-contained HTML page; nothing is drawn from numbers here."""

from pivotgait.reporting.folder import report_from_folder
from pivotgait.reporting.page import Picture, render_report, write_report
from pivotgait.reporting.summary import Trials
from pivotgait.reporting.verdict import Verdict, verdict

__all__ = [
    "Picture",
    "Trials",
    "Verdict",
    "render_report",
    "report_from_folder",
    "verdict",
    "write_report",
]
