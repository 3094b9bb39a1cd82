"""How much stronger the joints must be for a hand to do a gait, by bisection, tried out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pivotgait.exceptions import InfeasibleError
from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.mend_lines import Line, SceneMend
from pivotgait.gaits import plan_gait
from pivotgait.margins import LargestShare, largest_share
from pivotgait.models.parameters import EFFORT_SCALE, Value
from pivotgait.plans import GaitPlan

EFFORT_REACH = 30.0
"""Torque limits beyond this factor are not offered."""
HALVINGS = 7
"""Leave the factor within a few percent of the least one: postures differ by more."""


@dataclass(frozen=True)
class TorqueNeed:
    """What a gait asks of joints that are too weak for it.

    Attributes:
        share: the largest torque over its limit now, of the plan that is made without limits.
        mend: the factor of all torque limits that suffices.
    """

    share: LargestShare
    mend: SceneMend


def torque_need(
    variants: Variants,
    gait: str,
    changes: Mapping[str, Value],
    seed: int,
    tell: Callable[[str], None] = lambda text: None,
) -> TorqueNeed | None:
    """The factor by which all torque limits have to grow.

    Joints without limits tell the largest share, whose limits suffice: the same postures and
    forces do. Forces chosen by the limits may do with less; what they do with is bisected, each
    trial planned from the postures that were found, the last one from the seed alone.

    Args:
        variants: of the scene.
        gait: that cannot be done with the limits as they are.
        changes: to the scene.
        seed: of the hand's searches.
        tell: called with each factor that is tried.

    Returns:
        None where even joints :data:`EFFORT_REACH` times as strong do not help.
    """
    now = float(changes.get(EFFORT_SCALE, 1.0))

    def planned(scale: float, like: GaitPlan | None = None) -> GaitPlan | None:
        tell(f"{EFFORT_SCALE} = {scale:.4g}")
        scene = variants.scene_with({**changes, EFFORT_SCALE: scale})
        try:
            return plan_gait(scene, gait=gait, seed=seed, like=like)
        except InfeasibleError:
            return None

    strongest = EFFORT_REACH * now
    free = planned(strongest)
    share = None if free is None else largest_share(free, "torque")
    if share is None:
        return None
    line = Line(EFFORT_SCALE, now, strongest, now)
    # the margins are over the limits of the strong joints
    needed = replace(share, value=EFFORT_REACH * share.value)
    enough = line.mend(max(needed.value, 1.0) * now)
    low, high = np.log(now), np.log(enough.to)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if planned(float(np.exp(middle)), free) else (middle, high)
    for mend in (line.mend(float(np.exp(high))), enough):
        if planned(mend.to) is not None:
            return TorqueNeed(needed, mend)
    return None
