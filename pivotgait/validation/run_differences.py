"""Two runs of one plan, instant by instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Robot
from pivotgait.plans import GaitPlan
from pivotgait.validation.agreement import Tolerances
from pivotgait.validation.metrics import normal_forces
from pivotgait.validation.planned import planned_at
from pivotgait.validation.series import RunSeries
from pivotgait.validation.slips import fingertip_slips, tip_slip

_SAME_INSTANT_S = 1e-9
_MEND = "carry one plan out in both, with the same options"


@dataclass(frozen=True, eq=False)
class RunDifferences(FrozenArrays):
    """Two runs at the M rows that both have from the plan's start on; differences are absolute.

    Attributes:
        fingers: names, in the order of columns.
        time: (M,) since the plan's start [s].
        phase: (M,) index of the plan's phase as a float; the number of phases in the final hold.
        wanted: (M, fingers) 1 where a finger has business at the tool, else 0.
        normal_force_N: (M, fingers) along the planned normal on each real tool, 0 unless wanted.
        position_mm: (M,) of the tool's centre of mass.
        orientation_deg: (M,) angle from one tool to the other.
        tip_slips_mm: (M, 2) of each run.
        fingertip_slips_mm: (M, fingers, 2) of each run.
    """

    fingers: tuple[str, ...]
    time: Array
    phase: Array
    wanted: Array
    normal_force_N: Array
    position_mm: Array
    orientation_deg: Array
    tip_slips_mm: Array
    fingertip_slips_mm: Array

    @property
    def tip_slip_mm(self) -> Array:
        """(M,) difference of the ways of the tip."""
        return np.asarray(np.abs(np.diff(self.tip_slips_mm)[..., 0]))

    @property
    def fingertip_slip_mm(self) -> Array:
        """(M, fingers) difference of the ways of the fingertips."""
        return np.asarray(np.abs(np.diff(self.fingertip_slips_mm)[..., 0]))

    def within(self, tolerances: Tolerances) -> NDArray[np.bool_]:
        """(M,) whether every difference is within its tolerance at that instant."""
        found: NDArray[np.bool_] = (
            np.all(self.normal_force_N <= tolerances.normal_force_N, axis=1)
            & np.all(self.fingertip_slip_mm <= tolerances.fingertip_slip_mm, axis=1)
            & (self.position_mm <= tolerances.position_mm)
            & (self.orientation_deg <= tolerances.orientation_deg)
            & (self.tip_slip_mm <= tolerances.tip_slip_mm)
        )
        return found


def run_differences(plan: GaitPlan, robot: Robot, one: RunSeries, two: RunSeries) -> RunDifferences:
    """Differences of two runs up to the end of the shorter one.

    Args:
        plan: that both carried out.
        robot: of the plan.
        one: run; its rows must be those of the other.
        two: run.

    Raises:
        InputError: other fingers, other times, or a run that ends before the plan begins.
    """
    rows = min(len(one.time), len(two.time))
    runs = [each.first(rows) for each in (one, two)]
    apart = np.abs(runs[0].time - runs[1].time)
    if one.fingers != two.fingers or float(apart.max(initial=0.0)) > _SAME_INSTANT_S:
        raise InputError("are of other fingers or cycles", where="runs", mend=_MEND)
    begun = runs[0].time >= 0.0
    if not begun.any():
        raise InputError("end before the plan begins", where="runs", mend=_MEND)
    planned = planned_at(plan, runs[0].time, one.fingers)
    wanted = (planned.free == 0.0) | (planned.holds > 0.0)
    force = np.abs(np.subtract(*(normal_forces(each, planned) for each in runs)))
    turns = [Rotation.from_quat(each.tool_orientation) for each in runs]
    way = np.linalg.norm(runs[0].tool_position - runs[1].tool_position, axis=1)
    tips = np.stack([tip_slip(each) for each in runs], axis=-1)
    fingertips = [fingertip_slips(robot, each, planned) for each in runs]
    slips = [np.stack([each[name] for name in one.fingers], axis=1) for each in fingertips]
    return RunDifferences(
        fingers=one.fingers,
        time=runs[0].time[begun],
        phase=planned.phase[begun],
        wanted=wanted[begun],
        normal_force_N=np.where(wanted, force, 0.0)[begun],
        position_mm=1e3 * way[begun],
        orientation_deg=np.degrees((turns[0].inv() * turns[1]).magnitude())[begun],
        tip_slips_mm=1e3 * tips[begun],
        fingertip_slips_mm=1e3 * np.stack(slips, axis=-1)[begun],
    )
