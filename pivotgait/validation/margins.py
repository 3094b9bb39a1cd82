"""Friction margins of a run, beside those of its plan."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.validation.planned import Planned
from pivotgait.validation.series import RunSeries

_UP = np.array([0.0, 0.0, 1.0])


def measured_margins(series: RunSeries, planned: Planned) -> tuple[Array, Array]:
    """(N, fingers) and (N,) mu f_n - |f_t| of fingers and pivot in the run [N].

    With the planned friction and the planned normal, turned with the real tool: 0 where a finger
    has no contact in the plan.
    """
    turn = Rotation.from_quat(series.tool_orientation).as_matrix()
    in_tool = np.einsum("nji,nkj->nki", turn, series.force)
    return (
        _margin(in_tool, planned.normal, planned.friction),
        _margin(series.pivot_force, _UP, planned.pivot_friction),
    )


def planned_margins(planned: Planned) -> tuple[Array, Array]:
    """The same of the plan's forces."""
    return (
        _margin(planned.force, planned.normal, planned.friction),
        _margin(planned.pivot_force, _UP, planned.pivot_friction),
    )


def _margin(force: Array, normal: Array, friction: Array) -> Array:
    along = np.sum(force * normal, axis=-1)
    across = force - along[..., None] * normal
    touching = np.any(np.broadcast_to(normal, force.shape) != 0.0, axis=-1)
    return np.where(touching, friction * along - np.linalg.norm(across, axis=-1), 0.0)
