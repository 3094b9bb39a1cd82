"""The certificate of a plan: mechanics recomputed from the file, by code of its own.

Nothing here imports a planner or the formulas the planners use; what both must agree on is the
plan file and the equations of the paper.

To add a check: give its residual a name and a limit in ``limits.py``, write a small function
that yields a ``Finding`` for each phase (and contact), call it in ``assemble.py``, and add the
change of a valid plan that it must catch to ``tests/certification/test_certify.py`` (of a plan with
an arm-hand: ``test_robot.py``), which fails for a limit that nothing misses.
"""

from pivotgait.certification.assemble import certify
from pivotgait.certification.certificate import Certificate, Violation
from pivotgait.certification.limits import (
    LIMITS,
    ROBOT_LIMITS,
    TOOL_LIMITS,
    TRANSFER_LIMITS,
    Limit,
    with_clearance,
)

__all__ = [
    "LIMITS",
    "ROBOT_LIMITS",
    "TOOL_LIMITS",
    "TRANSFER_LIMITS",
    "Certificate",
    "Limit",
    "Violation",
    "certify",
    "with_clearance",
]
