"""Ferrari-Canny's ball: the largest external wrench, of any direction, that a grasp resists."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.rays import RayShooter
from pivotgait.frozen import Array, FrozenArrays

ROUNDS = 12
"""Of descent from direction to direction; two or three are usual."""
CERTAIN = 2e-3
"""Relative width of the bracket at which certification ends."""
SAME = 1e-5
"""Ends of rays this close, over the radius, count as one."""
FACETS_ADDED = 64
"""Weakest facets of the inner hull through which rays are shot in one round of certification."""


@dataclass(frozen=True, eq=False)
class WrenchBall(FrozenArrays):
    """The ball of disturbances around the load that the contacts can still oppose.

    Ferrari and Canny's epsilon with exact friction cones, limits per contact (their L-infinity
    measure), the table among the contacts, and the tool's load as the centre.

    Attributes:
        radius_N: largest r such that every external force F and moment M with
            sqrt(|F|^2 + (|M| / length_m)^2) <= r is resisted [N]; 0 where the load itself is not
            held, or only on an edge.
        at_least_N: proven from below: the ball fits into the hull of wrenches that were reached.
            ``radius_N`` is proven from above, by its direction.
        length_m: by which moments are divided [m].
        direction: (6,) the weakest disturbance, [force; moment], of size ``radius_N``, world
            [N, N m].
    """

    radius_N: float
    at_least_N: float
    length_m: float
    direction: Array


def wrench_ball(
    grasps: Grasps, length_m: float, *, shooter: RayShooter | None = None
) -> WrenchBall:
    """The largest ball of external wrenches that one grasp resists.

    The distance of the border is least where a supporting plane is normal to the ray. From each
    of 72 directions: the ray's end has a supporting plane; its normal is the next direction, and
    the plane's distance never grows. All ends lie on the border, so that their convex hull is
    inside the set: the distance of its nearest facet bounds the radius from below, and rays
    through its weakest facets close the bracket.

    Args:
        grasps: one grasp; with rows (joint torque limits) these are kept too.
        length_m: by which moments are divided [m]; a length of the tool, so that grasps of it
            compare: :func:`tool_length`.
        shooter: of this grasp, if there is one already.
    """
    shooter = shooter or RayShooter(grasps)
    if not shooter.inside:
        return WrenchBall(0.0, 0.0, length_m, np.zeros(6))
    metric = np.array([1.0, 1.0, 1.0, length_m, length_m, length_m])
    ways, best, weakest, ends = _starts(), np.inf, np.zeros(6), []
    for _ in range(ROUNDS):
        way, plane, end = _shoot(shooter, ways, metric)
        ends.append(end)
        ways, before = way, best
        nearest = int(np.argmin(plane))
        if plane[nearest] < best:
            best, weakest = float(plane[nearest]), way[nearest]
        if best > (1.0 - 1e-6) * before:
            break
    inner, better, way = _certified(shooter, metric, np.concatenate(ends), best)
    if better < best:
        best, weakest = better, way
    # a wrench of the world opposes what the contacts apply
    return WrenchBall(best, min(inner, best), length_m, -best * weakest * metric)


def _shoot(shooter: RayShooter, ways: Array, metric: Array) -> tuple[Array, Array, Array]:
    """Unit normals (D, 6) of the supporting planes, their distances (D,), the rays' ends (D, 6);
    in units of the metric."""
    rays = shooter.shoot(ways * metric)
    normal = rays.twist * metric
    size = np.linalg.norm(normal, axis=1)
    return normal / size[:, None], rays.reach / size, ways * rays.reach[:, None]


def _certified(
    shooter: RayShooter, metric: Array, ends: Array, best: float
) -> tuple[float, float, Array]:
    """Bounds of the radius from below and above, and the direction of the upper one."""
    inner, weakest = 0.0, np.zeros(6)
    for _ in range(ROUNDS):
        try:
            facets = ConvexHull(_distinct(ends, best), qhull_options="Qx Q12").equations
        except QhullError:  # a set so thin that rounding makes it flat
            break
        inner = max(inner, float(-facets[:, -1].max()))
        if inner >= (1.0 - CERTAIN) * best:
            break
        weak = facets[np.argsort(-facets[:, -1])[:FACETS_ADDED], :6]
        way, plane, end = _shoot(shooter, weak, metric)
        ends = np.concatenate((ends, end))
        nearest = int(np.argmin(plane))
        if plane[nearest] < best:
            best, weakest = float(plane[nearest]), way[nearest]
    return inner, best, weakest


def _distinct(ends: Array, size: float) -> Array:
    """Without the copies to which rays converge, on which Qhull stumbles."""
    _, first = np.unique(np.round(ends / (SAME * size)), axis=0, return_index=True)
    return ends[np.sort(first)]


def _starts() -> Array:
    """The axes, and the diagonals of every two of them."""
    eye = np.eye(6)
    pairs = [eye[i] + sign * eye[k] for i, k in combinations(range(6), 2) for sign in (1.0, -1.0)]
    half = np.concatenate((eye, np.array(pairs) / np.sqrt(2.0)))
    return np.concatenate((half, -half))


def tool_length(pivot_in_tool: Array) -> float:
    """Distance of the pivot from the centre of mass [m]: the length that moments are divided by.

    The load turns about the pivot with this lever, so that a force at the centre of mass and the
    moment it makes about the pivot count alike.
    """
    return float(np.linalg.norm(pivot_in_tool))
