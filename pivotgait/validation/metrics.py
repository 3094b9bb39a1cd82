"""How closely a run followed its plan, in numbers."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.validation.planned import Planned
from pivotgait.validation.series import RunSeries
from pivotgait.validation.slips import fingertip_slips, tip_slip
from pivotgait.validation.verdict import orientation_errors


@dataclass(frozen=True)
class Metrics:
    """Figures of one run, from the plan's start to where the run ended.

    Attributes:
        holding_force_rms_N: largest over the fingers of the RMS error of the normal force while
            a finger must hold [N].
        loading_force_rms_N: the same while its force grows from or shrinks to zero [N].
        orientation_deg: largest angle from the planned orientation [deg].
        tip_slip_mm: largest way of the tip along the table, before a transfer [mm].
        fingertip_slip_mm: largest way of a holding fingertip along the tool's surface [mm].
        torque_share: largest torque asked for over the joint's limit.
    """

    holding_force_rms_N: float
    loading_force_rms_N: float
    orientation_deg: float
    tip_slip_mm: float
    fingertip_slip_mm: float
    torque_share: float

    def as_json(self) -> dict[str, float]:
        """Plain data."""
        return asdict(self)


def measure(robot: Robot, series: RunSeries, planned: Planned) -> Metrics:
    """The figures of a run."""
    begun = series.time >= 0.0
    error = normal_forces(series, planned) - planned.normal_force
    slips = fingertip_slips(robot, series, planned)
    share = np.abs(series.tau) / np.where(robot.effort_max > 0.0, robot.effort_max, np.inf)
    return Metrics(
        holding_force_rms_N=_largest_rms(error, (planned.holds > 0) & begun[:, None]),
        loading_force_rms_N=_largest_rms(error, (planned.loads > 0) & begun[:, None]),
        orientation_deg=float(np.degrees(_most(orientation_errors(series, planned)[begun]))),
        tip_slip_mm=1e3 * _most(tip_slip(series)[planned.carried == 0.0]),
        fingertip_slip_mm=1e3 * max((_most(slip) for slip in slips.values()), default=0.0),
        torque_share=_most(share[begun]),
    )


def normal_forces(series: RunSeries, planned: Planned) -> Array:
    """(N, fingers) true force of each finger along the planned normal on the real tool [N]."""
    turn = Rotation.from_quat(series.tool_orientation).as_matrix()
    return np.asarray(np.einsum("nki,nij,nkj->nk", series.force, turn, planned.normal))


def _largest_rms(error: Array, counted: NDArray[np.bool_]) -> float:
    """Largest over the columns of the RMS of the rows that count; 0 without any."""
    squares = [
        float(np.mean(column[rows] ** 2))
        for column, rows in zip(error.T, counted.T, strict=True)
        if rows.any()
    ]
    return float(np.sqrt(max(squares, default=0.0)))


def _most(values: Array) -> float:
    return float(np.max(values, initial=0.0))
