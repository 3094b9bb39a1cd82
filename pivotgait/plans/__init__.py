"""The artefact: a gait plan as data, and its HDF5 file. No planning happens here."""

from pivotgait.plans.check import check_plan
from pivotgait.plans.file import read_plan, with_certificate, write_plan
from pivotgait.plans.plan import (
    PIVOT,
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    RobotMotion,
    ToolMotion,
)

__all__ = [
    "PIVOT",
    "ContactTrack",
    "GaitPlan",
    "Phase",
    "PlannedFinger",
    "PlannedRobot",
    "PlannedTool",
    "RobotMotion",
    "ToolMotion",
    "check_plan",
    "read_plan",
    "with_certificate",
    "write_plan",
]
