"""From a scene's list of phases to a gait plan."""

from pivotgait.gaits.continuing import Continuation, Correction, MeasuredState, continue_gait
from pivotgait.gaits.planner import PhaseDone, PosturesFound, plan_gait

__all__ = [
    "Continuation",
    "Correction",
    "MeasuredState",
    "PhaseDone",
    "PosturesFound",
    "continue_gait",
    "plan_gait",
]
