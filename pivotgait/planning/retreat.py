"""The way of a fingertip along its contact's normal, off the tool or onto it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.validity import Validity

STEP = 0.001
"""Way of the tip between two configurations [m]."""
CORRECTIONS = 4
"""Newton steps of the tip's place."""
PLACE_TOLERANCE = 2e-4
"""Of the tip's place on the line [m]."""
LEAST_SHARE = 0.35
"""Of the wanted length that must be possible."""


def retreat(
    problem: RelocationProblem,
    manifold: Manifold,
    validity: Validity,
    q: Array,
    s: float,
    normal: Array | None,
) -> Array | None:
    """Configurations (N, nv) from a touching one outward along the normal at a standing tool.

    Args:
        problem: with the length in its options.
        manifold: of the problem.
        validity: of the problem.
        q: (nv,) where the finger touches.
        s: parameter of the tool's path there.
        normal: (3,) inward normal, tool frame; None for a finger in the air, which stays there.

    Returns:
        ``q`` first; None if the finger cannot leave along the normal without a collision.
    """
    if normal is None:
        return q[None].copy()
    way, start = [q], manifold.tip(q, s)
    total = int(np.ceil(problem.options.retreat / STEP))
    least = int(np.ceil(LEAST_SHARE * total))
    for k in range(1, total + 1):
        place = start.translation - k * STEP * normal
        q_next = _reach(manifold, validity, way[-1], s, pin.SE3(start.rotation, place))
        if q_next is None or not validity.way_free(way[-1], s, q_next, s):
            if q_next is not None:
                manifold.counts.collision += 1
            break
        way.append(q_next)
    return np.array(way) if len(way) > least else None


def _reach(
    manifold: Manifold, validity: Validity, q: Array, s: float, target: pin.SE3
) -> Array | None:
    """A configuration near q with the tip's centre in place, its orientation free.

    The first step also widens narrow gaps.
    """
    stay = np.zeros(len(q))
    gaps: tuple[Array, Array] | None = validity.narrow(q, s)
    for _ in range(CORRECTIONS):
        try:
            q = q + manifold.step(q, s, target, 10.0 * STEP, stay, turning=False, gaps=gaps)
        except SingularCoordinatesError:
            return None
        settled = manifold.settle(q, s)
        if settled is None:
            return None
        q = settled
        error = np.linalg.norm(manifold.tip(q, s).translation - target.translation)
        if error <= PLACE_TOLERANCE:
            return q
        gaps = None
    return None
