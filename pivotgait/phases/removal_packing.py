"""Between the numbers of a removal and the vectors of its nonlinear program."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts.grasp_map import skew
from pivotgait.phases.removal_model import PARAMETERS
from pivotgait.phases.removal_problem import RemovalProblem

Array = NDArray[np.float64]

FRICTION_RESERVE = 1e-6
"""Relative reserve of friction: a cone is then kept to 1e-8 N in spite of a tolerance of 1e-8."""
BOUND_RESERVE_N = 1e-7
"""Reserve of the bounds of normal forces [N], for the same reason."""


def pack(problem: RemovalProblem) -> Array:
    """Parameters of the program in the order of :data:`removal_model.PARAMETERS`."""
    body = problem.body
    friction = problem.friction * (1.0 - FRICTION_RESERVE)
    moments = skew(problem.points - body.pivot_in_tool) @ problem.frames
    values: dict[str, Any] = {
        "orientation": problem.orientation,
        "step_s": problem.step_s,
        "mass": body.mass,
        "weight": body.mass * body.gravity,
        "arm": -body.pivot_in_tool,
        "about_pivot": body.inertia_about_pivot,
        "frames": problem.frames.transpose(2, 1, 0).reshape(9, -1),
        "moments": moments.transpose(2, 1, 0).reshape(9, -1),
        "friction": friction,
        "normal_min": problem.normal_min + BOUND_RESERVE_N,
        "normal_max": problem.normal_max - BOUND_RESERVE_N,
        "start_local": problem.start_local.T,
        # the same reserve as the friction's keeps the rate exactly
        "change_max": problem.change_max * (1.0 - FRICTION_RESERVE) if problem.rated else 0.0,
        "clear_lever": problem.clear_lever.T,
        "clear_rise": problem.clear_rise,
        "weights": problem.weights.as_array,
    }
    return np.concatenate([np.ravel(values[name], order="F") for name in PARAMETERS])


def places(states: list[int], controls: list[int], staying: int) -> dict[str, Any]:
    """Where each quantity stands in the vector of variables, as index arrays over stages."""
    stages = len(states)
    size = np.array(states) + np.array(controls)
    first = np.concatenate(([0], np.cumsum(size)[:-1]))
    control = first + np.array(states)
    last = np.arange(stages) == stages - 1
    fingers = control + np.where(last, 0, 3)
    leaving = fingers + 3 * staying
    table = leaving + np.where(last, 0, 2)
    return {
        "size": int(size.sum()),
        "attitude": first[:, None] + np.arange(4),
        "omega": first[:, None] + np.arange(4, 7),
        "s": control[:-1, None] + np.arange(3),
        "fingers": fingers[:, None] + np.arange(3 * staying),
        "leaving": leaving[:-1, None] + np.arange(2),
        "table": table[:, None] + np.arange(3),
    }


def force_of(parts: Array) -> Array:
    """f = f_n (tau_x, tau_y, 1) from rows (tau_x, tau_y, f_n)."""
    return np.column_stack((parts[:, :2] * parts[:, 2:], parts[:, 2]))


def slopes_of(force: Array) -> Array:
    """tau = f_t / f_n of rows (f_x, f_y, f_n); 0 where there is no force."""
    loaded = np.abs(force[:, 2:]) > 1e-9
    return np.where(loaded, force[:, :2] / np.where(loaded, force[:, 2:], 1.0), 0.0)
