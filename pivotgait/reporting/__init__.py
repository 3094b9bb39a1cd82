"""A gait or a sweep as one self-contained HTML page; nothing is drawn from numbers here."""

from pivotgait.reporting.folder import report_from_folder
from pivotgait.reporting.page import Picture, render_report, write_report
from pivotgait.reporting.report_files import Report
from pivotgait.reporting.study_page import report_from_sweep
from pivotgait.reporting.summary import Trials
from pivotgait.reporting.verdict import Verdict, verdict

__all__ = [
    "Picture",
    "Report",
    "Trials",
    "Verdict",
    "render_report",
    "report_from_folder",
    "report_from_sweep",
    "verdict",
    "write_report",
]
