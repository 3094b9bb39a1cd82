"""An allocation problem in contact coordinates: what every solver starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.forces.problem import AllocationProblem

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LocalForm:
    """Forces x (T, m, 3) in contact coordinates (t_x, t_y, n), stacked to (T, 3 m).

    Attributes:
        frames: (T, m, 3, 3) rotations, problem's frame <- contact frame.
        grasp: (T, 6, 3 m) with wrench = grasp @ x.
        rows: (T, r, 3 m) the problem's linear rows on x (r may be 0).
        lower: (T, r).
        upper: (T, r).
        known: (T, m, 3) which coordinates are prescribed.
        value: (T, m, 3) their values [N], 0 where free.
        low: (T, m) lower bound rows wanted: bound > 0 and the normal force is free; else NaN.
        high: (T, m) upper bound rows wanted: bound finite and the normal force free; else NaN.
    """

    frames: Array
    grasp: Array
    rows: Array
    lower: Array
    upper: Array
    known: Mask
    value: Array
    low: Array
    high: Array

    def world(self, x: Array) -> Array:
        """(T, m, 3) forces in the problem's frame from contact coordinates."""
        return np.asarray((self.frames @ x[..., None])[..., 0])


def local_form(problem: AllocationProblem) -> LocalForm:
    """Contact coordinates of a problem; cone and lower bound 0 say the same, so that is dropped.

    A normal force whose bounds meet is prescribed, like the ramps of Xue et al., eqs (7), (8).
    """
    t, m = problem.samples, problem.contacts
    frames = contact_frame(problem.normals)
    turn = frames[:, None]  # forces of each contact, stacked: right-multiply block by block
    grasp = grasp_map(problem.lever).reshape(t, 6, m, 1, 3) @ turn
    if problem.rows is None:
        rows, lower, upper = np.zeros((t, 0, 3 * m)), np.zeros((t, 0)), np.zeros((t, 0))
    else:
        local = problem.rows.matrix.reshape(t, -1, m, 1, 3) @ turn
        rows, lower, upper = local.reshape(t, -1, 3 * m), problem.rows.lower, problem.rows.upper

    given = problem.fixed
    meet = np.isnan(given) & (problem.normal_min == problem.normal_max)
    given = np.where(meet, problem.normal_max, given)
    free = np.isnan(given)
    known = np.zeros((t, m, 3), dtype=bool)
    known[..., 2] = ~free
    known[~problem.loaded | (given == 0.0)] = True
    value = np.zeros((t, m, 3))
    value[..., 2] = np.where(free, 0.0, given)
    return LocalForm(
        frames=frames,
        grasp=grasp.reshape(t, 6, 3 * m),
        rows=rows,
        lower=lower,
        upper=upper,
        known=known,
        value=value,
        low=np.where(free & (problem.normal_min > 0.0), problem.normal_min, np.nan),
        high=np.where(free & np.isfinite(problem.normal_max), problem.normal_max, np.nan),
    )
