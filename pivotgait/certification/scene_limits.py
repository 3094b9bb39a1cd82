"""The limits that a plan's own scene asks for."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pivotgait.certification.limits import LIMITS, Limit, with_clearance
from pivotgait.exceptions import SceneError
from pivotgait.models.scene_yaml import read_yaml

_LARGEST_CLEARANCE = 0.1


def scene_limits(scene: str) -> Mapping[str, Limit]:
    """:data:`LIMITS` with the ``clearance_m`` of a scene's YAML text, if it has one.

    Only that field is read: loading the whole scene would need the tool's URDF file, and a plan
    file must stand alone.

    Raises:
        SceneError: if the text is not YAML, or the clearance is not within 0 to 0.1 m.
    """
    if not scene.strip():
        return LIMITS
    where = "scene of the plan"
    clearance = read_yaml(scene, where=where).get("clearance_m")
    if clearance is None:
        return LIMITS
    numeric = isinstance(clearance, int | float) and not isinstance(clearance, bool)
    if not (numeric and math.isfinite(clearance) and 0.0 <= clearance <= _LARGEST_CLEARANCE):
        raise SceneError(
            f"clearance_m is {clearance!r}", where=where, mend=f"0 to {_LARGEST_CLEARANCE:g} m"
        )
    return with_clearance(float(clearance))
