"""Results in, matplotlib Figures out: nothing is planned or solved here."""

from pivotgait.plotting.angle import angle_to_normal
from pivotgait.plotting.comparison import comparison
from pivotgait.plotting.cone import force_in_cone
from pivotgait.plotting.feasibility_maps import feasibility_maps
from pivotgait.plotting.forces import normal_forces
from pivotgait.plotting.joints import joint_positions, joint_speeds, joint_torques
from pivotgait.plotting.margins import margins
from pivotgait.plotting.orientation import orientation
from pivotgait.plotting.overview import overview
from pivotgait.plotting.robot_scene import robot_scene
from pivotgait.plotting.robust_margins import robust_margins
from pivotgait.plotting.run_deviations import run_deviations
from pivotgait.plotting.run_forces import run_angles, run_normal_forces
from pivotgait.plotting.run_replay import replay
from pivotgait.plotting.run_strip import run_strip
from pivotgait.plotting.run_torques import run_torques
from pivotgait.plotting.save import SavedFigure, figure_bytes, save_figure
from pivotgait.plotting.snapshots import gait_strip, tool_snapshots
from pivotgait.plotting.style import COLUMN_WIDTH, PAGE_WIDTH, contact_colours

__all__ = [
    "COLUMN_WIDTH",
    "PAGE_WIDTH",
    "SavedFigure",
    "angle_to_normal",
    "comparison",
    "contact_colours",
    "feasibility_maps",
    "figure_bytes",
    "force_in_cone",
    "gait_strip",
    "joint_positions",
    "joint_speeds",
    "joint_torques",
    "margins",
    "normal_forces",
    "orientation",
    "overview",
    "replay",
    "robot_scene",
    "robust_margins",
    "run_angles",
    "run_deviations",
    "run_normal_forces",
    "run_strip",
    "run_torques",
    "save_figure",
    "tool_snapshots",
]
