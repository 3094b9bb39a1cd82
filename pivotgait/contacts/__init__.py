"""Contact frames, friction cones (exact and inner pyramid) and the grasp map."""

from pivotgait.contacts.cone import cone_margin, friction_margin, inner_pyramid
from pivotgait.contacts.frame import contact_frame
from pivotgait.contacts.grasp_map import grasp_map

__all__ = ["cone_margin", "contact_frame", "friction_margin", "grasp_map", "inner_pyramid"]
