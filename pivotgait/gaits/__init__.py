"""From a scene's list of phases to a gait plan."""

from pivotgait.gaits.planner import PhaseDone, PosturesFound, plan_gait

__all__ = ["PhaseDone", "PosturesFound", "plan_gait"]
