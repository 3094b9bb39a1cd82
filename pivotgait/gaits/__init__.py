"""From a scene's list of phases to a gait plan."""

from pivotgait.gaits.planner import PhaseDone, plan_gait

__all__ = ["PhaseDone", "plan_gait"]
