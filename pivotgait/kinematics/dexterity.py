"""How far a finger on its palm is from losing a coordinate of its contact, with the gradient.

A finger that holds must move its tip's centre and keep its tilt, five coordinates (eq. 9). Where
its own joints can no longer do that, for a thumb of five joints when its self-motion becomes a
pure spin about the contact normal, the task Jacobian H becomes singular whatever the palm adds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import lapack

from pivotgait.frozen import Array
from pivotgait.kinematics.closed_chain import ROWS_PER_HOLD

_LEAST_SQUARE = 1e-20  # [m^2]: the gradient at an exactly singular finger is not defined


def dexterity(
    jacobian: Array,
    normal: Array,
    own: Sequence[int],
    angle_length: float,
    *,
    below: float = np.inf,
) -> tuple[float, Array | None]:
    """Smallest singular value of a finger's own five-row contact Jacobian, and its gradient.

    The rows are the tip's velocity and, as a length, the part of its angular velocity across the
    contact normal: singular values do not depend on the axes they are written in. With world
    columns w_k (rotation) and p_k (tip's velocity) of the joints on the way to the tip, joint j
    turns those behind it, d w_k/dq_j = w_j x w_k and d p_k/dq_j = w_j x p_k for j <= k, and moves
    the tip for those before it, d p_k/dq_j = w_k x p_j for j > k.

    Args:
        jacobian: (6, nv) of the tip, [linear; angular], world axes at the tip's centre; columns
            in an order in which a joint comes before those it carries.
        normal: (3,) unit contact normal, world.
        own: columns of the finger's joints, in that order.
        angle_length: length that stands for one radian [m].
        below: the gradient is wanted only for a sigma smaller than this [m].

    Returns:
        sigma [m], the fifth singular value of more than five joints, and d sigma/dq (nv,), the
        normal being fixed in the world; None if not wanted.
    """
    columns = np.asarray(own)
    linear, angular = jacobian[:3], jacobian[3:]
    across = np.eye(3) - np.outer(normal, normal)
    rows = np.concatenate((linear[:, columns], angle_length * (across @ angular[:, columns])))
    # By the eigenvalues of the small square, several times as fast as a singular value
    # decomposition; what it loses in digits is far below what matters near 1e-3 m.
    squares, vectors, _ = lapack.dsyev(rows.T @ rows)
    least = max(len(columns) - ROWS_PER_HOLD, 0)  # those before it move the joints alone
    sigma = float(max(squares[least], _LEAST_SQUARE) ** 0.5)
    if not sigma < below:
        return sigma, None
    left = rows @ vectors[:, least] / sigma
    push, twist = left[:3], angle_length * (across @ left[3:])
    share = np.zeros(jacobian.shape[1])
    share[columns] = vectors[:, least]
    behind = _sums_from_the_end(share * linear), _sums_from_the_end(share * angular)
    before = behind[1][:, :1] - behind[1]
    gradient = (
        _triple(angular, behind[0], push)
        + _triple(before, linear, push)
        + _triple(angular, behind[1], twist)
    )
    return sigma, gradient


def _sums_from_the_end(columns: Array) -> Array:
    """Column j is the sum of the columns from j on."""
    return np.asarray(np.cumsum(columns[:, ::-1], axis=1)[:, ::-1])


def _triple(first: Array, second: Array, along: Array) -> Array:
    """(n,) along . (first_j x second_j) of columns (3, n)."""
    cross = np.stack(
        (
            first[1] * second[2] - first[2] * second[1],
            first[2] * second[0] - first[0] * second[2],
            first[0] * second[1] - first[1] * second[0],
        )
    )
    return np.asarray(along @ cross)
