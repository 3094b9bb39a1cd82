"""Local coordinates, the closed chain of arm, fingers and tool, and its conditioning."""

from pivotgait.kinematics.closed_chain import ClosedChain
from pivotgait.kinematics.conditioning import (
    PalmChoice,
    PalmRows,
    TaskJacobian,
    choose_palm_rows,
    palm_axes,
    smallest_singular_value,
)
from pivotgait.kinematics.frame_coordinates import FrameCoordinates
from pivotgait.kinematics.hold import Hold
from pivotgait.kinematics.local_coordinates import (
    angles_from_rotation,
    rate_map,
    rate_map_derivative,
    rotation_from_angles,
)
from pivotgait.kinematics.projection import Projection, project, resolve
from pivotgait.kinematics.rigid_motion import RigidMotion, cross_matrix
from pivotgait.kinematics.sampled_motion import differentiate

__all__ = [
    "ClosedChain",
    "FrameCoordinates",
    "Hold",
    "PalmChoice",
    "PalmRows",
    "Projection",
    "RigidMotion",
    "TaskJacobian",
    "angles_from_rotation",
    "choose_palm_rows",
    "cross_matrix",
    "differentiate",
    "palm_axes",
    "project",
    "rate_map",
    "rate_map_derivative",
    "resolve",
    "rotation_from_angles",
    "smallest_singular_value",
]
