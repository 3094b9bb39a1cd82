"""How far tip and fingertips have moved where they should not."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.validation.planned import Planned
from pivotgait.validation.series import RunSeries

Rows = NDArray[np.intp]

_TOUCHING_N = 0.1
"""A fingertip that comes has arrived when its force exceeds this."""
_EVERY_S = 0.005
_LIFTED_M = 5e-3
"""A tip this far over the table is off it for good: a tool that tips back comes less far."""


def tip_slip(series: RunSeries) -> Array:
    """(N,) distance along the table of the tip from where it was at the plan's start [m].

    0 while it is off the table, by more than 5 mm, as after a transfer.
    """
    turn = Rotation.from_quat(series.tool_orientation).as_matrix()
    tip = series.tool_position + turn @ series.pivot_in_tool
    start = min(int(np.searchsorted(series.time, 0.0)), len(tip) - 1)
    way = tip - tip[start]
    slip = np.linalg.norm(way[:, :2], axis=1)
    slip[:start] = 0.0
    slip[way[:, 2] > _LIFTED_M] = 0.0
    return np.asarray(slip)


def fingertip_slips(robot: Robot, series: RunSeries, planned: Planned) -> dict[str, Array]:
    """(N,) distance along the tool's surface of each fingertip from where it arrived [m].

    Seen from the real tool and across the planned normal, from the plan's start or the instant
    a coming finger bears 0.1 N. A fingertip that rolls counts as one that slips. Evaluated every
    5 ms and held between.
    """
    step = max(round(_EVERY_S / _period(series.time)), 1)
    rows = np.arange(0, len(series.time), step)
    tips = _tips_in_tool(robot, series, rows)
    found = {}
    for k, name in enumerate(series.fingers):
        slip = _slip(series, planned, tips[:, k], rows, k)
        found[name] = np.repeat(slip, step)[: len(series.time)]
    return found


def _slip(series: RunSeries, planned: Planned, tips: Array, rows: Rows, finger: int) -> Array:
    normal = planned.normal[rows, finger]
    bearing = np.linalg.norm(series.force[rows, finger], axis=1) > _TOUCHING_N
    holds, loads = planned.holds[rows, finger] > 0, planned.loads[rows, finger] > 0
    begun = series.time[rows] >= 0.0
    counted = begun & (holds | (loads & bearing))
    slip = np.zeros(len(rows))
    origin = None
    for row in range(len(rows)):
        moved_on = row > 0 and bool(np.any(normal[row] != normal[row - 1]))
        if not begun[row] or moved_on or not (holds[row] or loads[row]):
            origin = None
        if not counted[row]:
            continue
        origin = tips[row] if origin is None else origin
        way = tips[row] - origin
        slip[row] = np.linalg.norm(way - (way @ normal[row]) * normal[row])
    return slip


def _tips_in_tool(robot: Robot, series: RunSeries, rows: Rows) -> Array:
    """(rows, fingers, 3) centres of the fingertips in the real tool's frame [m]."""
    data = robot.model.createData()
    frames = [robot.fingers[name].tip_frame_id for name in series.fingers]
    centres = np.zeros((len(rows), len(frames), 3))
    for k, q in enumerate(np.array(series.q[rows])):
        pin.forwardKinematics(robot.model, data, q)
        for place, frame in enumerate(frames):
            centres[k, place] = pin.updateFramePlacement(robot.model, data, frame).translation
    turn = Rotation.from_quat(series.tool_orientation[rows]).as_matrix()
    away = centres - series.tool_position[rows, None]
    return np.asarray(np.einsum("nji,nkj->nki", turn, away))


def _period(time: Array) -> float:
    return float(time[1] - time[0]) if len(time) > 1 else 1.0
