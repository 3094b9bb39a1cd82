"""Pivot kinematics and Newton-Euler dynamics of the tool (Xue et al., eqs 1-3)."""

from pivotgait.dynamics.newton_euler import pivot_dynamics, required_wrench, world_inertia
from pivotgait.dynamics.pivot import PivotingTool, pivot_motion

__all__ = [
    "PivotingTool",
    "pivot_dynamics",
    "pivot_motion",
    "required_wrench",
    "world_inertia",
]
