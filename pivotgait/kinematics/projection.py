"""Configurations and joint velocities that keep the closed chain closed (Section V)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics.closed_chain import ClosedChain
from pivotgait.kinematics.minimum_norm import minimum_norm, mobility


@dataclass(frozen=True, eq=False)
class Projection(FrozenArrays):
    """The end of a Newton search for a closed chain; a failed one is a record too.

    Attributes:
        q: (nv,) last configuration; joint limits are the caller's to check.
        residual_norm: Euclidean norm of the scaled residual there [m].
        iterations: Newton steps taken.
        converged: whether ``residual_norm`` is within the tolerance.
    """

    q: Array
    residual_norm: float
    iterations: int
    converged: bool


def project(
    chain: ClosedChain,
    q: Array,
    oRtool: Array,
    tool_position: Array,
    *,
    tolerance: float = 1e-10,
    max_iterations: int = 20,
    weights: Array | None = None,
    fixed: Sequence[int] = (),
    angle_length: float | None = None,
    max_step: float = 1.0,
) -> Projection:
    """Newton's method on eq. (9) with steps of least weighted norm, from q.

    Angles count as lengths: times the finger's tip radius, or times ``angle_length``. The chain
    is left updated at the returned q.

    Args:
        chain: the holding fingers.
        q: (nv,) start.
        oRtool: (3, 3) orientation of the tool, world <- tool.
        tool_position: (3,) origin of the tool frame, world [m].
        tolerance: of the residual's norm [m].
        max_iterations: most Newton steps.
        weights: (nv,) positive diagonal metric of steps, ones if not given.
        fixed: columns of joints that stay.
        angle_length: length of one radian [m].
        max_step: longest step, the norm over all joints [rad, m].

    Returns:
        The projection; not converged when the steps ran out, or the search came where the
        coordinates are singular.

    Raises:
        SingularCoordinatesError: if the coordinates are singular at the start.
        InputError: for weights that are not positive.
    """
    scale = mobility(weights, fixed, chain.robot.nv)
    lengths = chain.row_lengths(angle_length)
    chain.update(q, oRtool, tool_position)
    scaled = chain.residual * lengths
    norm, iterations = _norm(scaled), 0
    point = np.array(q, dtype=float)
    while norm > tolerance and iterations < max_iterations:
        step = minimum_norm(chain.jacobian * lengths[:, None], -scaled, scale)
        size = _norm(step)
        trial = point + (step if size <= max_step else step * (max_step / size))
        try:
            chain.update(trial, oRtool, tool_position)
        except SingularCoordinatesError:
            chain.update(point, oRtool, tool_position)
            break
        point, iterations = trial, iterations + 1
        scaled = chain.residual * lengths
        norm = _norm(scaled)
    return Projection(
        q=point, residual_norm=norm, iterations=iterations, converged=norm <= tolerance
    )


def resolve(
    chain: ClosedChain,
    target_rate: Array,
    wanted: Array,
    *,
    weights: Array | None = None,
    fixed: Sequence[int] = (),
) -> Array:
    """Joint velocities nearest to the wanted ones among those that keep the chain closed.

    qdot = argmin |qdot - wanted|_W subject to A qdot = b at the chain's last update, that is
    qdot = A+ b + (I - A+ A) wanted with the weighted pseudo-inverse A+.

    Args:
        chain: updated at the present configuration.
        target_rate: (5 m,) b, of :meth:`ClosedChain.target_rate`; zeros for a resting tool.
        wanted: (nv,) joint velocities without the constraint (q_null of Section V).
        weights: (nv,) positive diagonal of W, ones if not given.
        fixed: columns of joints that keep their wanted velocity.

    Returns:
        (nv,) joint velocities.

    Raises:
        InputError: for weights that are not positive.
    """
    scale = mobility(weights, fixed, chain.robot.nv)
    missing = target_rate - chain.jacobian.dot(wanted)
    return np.asarray(wanted + minimum_norm(chain.jacobian, missing, scale))


def _norm(vector: Array) -> float:
    return float(vector.dot(vector) ** 0.5)
