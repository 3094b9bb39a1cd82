"""How far a plan stays from slipping, from lifting its tip and from its force bounds."""

from pivotgait.margins.gait import ContactMargins, PhaseMargins, gait_margins, phase_margins
from pivotgait.margins.joints import (
    SHARE_KINDS,
    JointShares,
    LargestShare,
    joint_shares,
    largest_share,
)
from pivotgait.margins.smallest import MARGIN_KINDS, Margin, smallest_margin, smallest_of_phase

__all__ = [
    "MARGIN_KINDS",
    "SHARE_KINDS",
    "ContactMargins",
    "JointShares",
    "LargestShare",
    "Margin",
    "PhaseMargins",
    "gait_margins",
    "joint_shares",
    "largest_share",
    "phase_margins",
    "smallest_margin",
    "smallest_of_phase",
]
