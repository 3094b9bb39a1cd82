"""Control laws that carry a plan out, behind one contract."""

from pivotgait.control.admittance import AdmittanceController, AdmittanceGains
from pivotgait.control.controller import Controller
from pivotgait.control.feedforward import FeedForwardController
from pivotgait.control.gains import HybridGains
from pivotgait.control.hybrid import HybridController
from pivotgait.control.measurement import Measurement
from pivotgait.control.position import PositionController
from pivotgait.control.recovery import RecoveringController
from pivotgait.control.recovery_event import RecoveryEvent
from pivotgait.control.recovery_options import RecoveryOptions
from pivotgait.control.reference import Reference
from pivotgait.control.tool_feedback import ToolGains
from pivotgait.control.tool_state import ToolState

__all__ = [
    "AdmittanceController",
    "AdmittanceGains",
    "Controller",
    "FeedForwardController",
    "HybridController",
    "HybridGains",
    "Measurement",
    "PositionController",
    "RecoveringController",
    "RecoveryEvent",
    "RecoveryOptions",
    "Reference",
    "ToolGains",
    "ToolState",
]
