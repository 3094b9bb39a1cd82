"""A path of states as a smooth curve on the closed chain's manifold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from pivotgait.frozen import Array
from pivotgait.planning.manifold import TOLERANCE, Manifold

DEGREE = 3
"""Of the B-spline that rounds the corners."""
NODES_PER_CONTROL = 4
"""Projected nodes of the curve for each control point."""
INTERPOLATION = 5
"""Degree of the spline through the projected nodes: third derivatives stay continuous."""


@dataclass(frozen=True, eq=False)
class SmoothPath:
    """q(u) and s(u), u in [0, 1], four times continuously differentiable.

    Attributes:
        curve: spline of (nv + 1,): q, then s.
        nodes: (M,) values of u at which it was projected on the manifold.
    """

    curve: BSpline
    nodes: Array

    def __call__(self, u: Array, derivative: int = 0) -> tuple[Array, Array]:
        """q (N, nv) and s (N,), or their derivatives with respect to u."""
        values = np.asarray(self.curve(u, nu=derivative))
        return values[:, :-1], values[:, -1]


def smooth(
    manifold: Manifold, q: Array, s: Array, speed_max: Array, spacing: float
) -> SmoothPath | None:
    """Round a path's corners.

    Points at even distances along the path become the control points of a cubic B-spline, which
    stays in their hull, hence within joint limits and couplings, and within about ``spacing`` of
    the path; it is projected on (9) node by node and interpolated.

    Args:
        manifold: of the problem.
        q: (N, nv) states of the path, N >= 2.
        s: (N,) parameter of the tool's path.
        speed_max: (nv,) by which distances along the path are measured: the time of the slowest
            joint.
        spacing: between control points, as a bound on motion [m].

    Returns:
        The curve, or None if a node could not be projected.
    """
    steps = np.abs(np.diff(q, axis=0)) / speed_max
    motion = manifold.motions(q, s)
    # A joint's time, and a little of the motion, so that no piece has length 0.
    at = np.concatenate(([0.0], np.cumsum(steps.max(axis=1) + 1e-3 * motion + 1e-12)))
    at /= at[-1]
    count = max(int(np.ceil(motion.sum() / spacing)) + 1, 2 * DEGREE)
    states = np.column_stack((q, s))
    grid = np.linspace(0.0, 1.0, count)
    control = np.column_stack([np.interp(grid, at, column) for column in states.T])
    inner = np.linspace(0.0, 1.0, count - DEGREE + 1)
    knots = np.concatenate((np.zeros(DEGREE), inner, np.ones(DEGREE)))
    rounded = BSpline(knots, control, DEGREE)
    nodes = np.linspace(0.0, 1.0, NODES_PER_CONTROL * count)
    values = np.asarray(rounded(nodes))
    values[0], values[-1] = states[0], states[-1]
    for k in range(1, len(values) - 1):
        settled = manifold.settle(values[k, :-1], float(values[k, -1]), TOLERANCE)
        if settled is None:
            return None
        values[k, :-1] = settled
    return SmoothPath(make_interp_spline(nodes, values, k=INTERPOLATION), nodes)
