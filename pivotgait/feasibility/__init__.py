"""Is a grasp or a gait feasible, what binds, what mends it, and how far is the edge?"""

from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.maps import FeasibilityMap, MapAxis, trace_map, trace_slices
from pivotgait.feasibility.questions import Question
from pivotgait.feasibility.rays import Rays, RayShooter
from pivotgait.feasibility.rehearsal import Obstacle, Rehearsal, rehearse
from pivotgait.feasibility.robustness import RobustMargins, friction_drop, robust_margins
from pivotgait.feasibility.sensitivity import Sensitivity, sensitivity
from pivotgait.feasibility.shares import ShareMap, share_map
from pivotgait.feasibility.static_verdicts import StaticVerdicts, static_verdicts
from pivotgait.feasibility.support import holding_power, support
from pivotgait.feasibility.tightest import Tightest, tightest_limit
from pivotgait.feasibility.turns import Turn, held_at, smallest_tilt
from pivotgait.feasibility.verdict import Binding, Verdict, VerdictOptions, judge
from pivotgait.feasibility.wrench_ball import WrenchBall, tool_length, wrench_ball
from pivotgait.feasibility.wrench_volume import WrenchVolume, wrench_volume

__all__ = [
    "Binding",
    "FeasibilityMap",
    "Grasps",
    "MapAxis",
    "Obstacle",
    "Question",
    "RayShooter",
    "Rays",
    "Rehearsal",
    "RobustMargins",
    "Sensitivity",
    "ShareMap",
    "StaticVerdicts",
    "Tightest",
    "Turn",
    "Variants",
    "Verdict",
    "VerdictOptions",
    "WrenchBall",
    "WrenchVolume",
    "friction_drop",
    "held_at",
    "holding_power",
    "judge",
    "rehearse",
    "robust_margins",
    "sensitivity",
    "share_map",
    "smallest_tilt",
    "static_verdicts",
    "support",
    "tightest_limit",
    "tool_length",
    "trace_map",
    "trace_slices",
    "wrench_ball",
    "wrench_volume",
]
