"""URDF files checked before any native parser sees them."""

from pivotgait.models.urdf.check import check_urdf, read_urdf
from pivotgait.models.urdf.record import UrdfInertial, UrdfJoint, UrdfLink, UrdfSummary

__all__ = ["UrdfInertial", "UrdfJoint", "UrdfLink", "UrdfSummary", "check_urdf", "read_urdf"]
