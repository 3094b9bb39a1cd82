"""The grasp map: from contact forces to the wrench on the tool."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def skew(vector: Array) -> Array:
    """(..., 3, 3) matrices [v]x with [v]x u = v x u."""
    v = np.asarray(vector, dtype=float)
    matrix = np.zeros((*v.shape[:-1], 3, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


def grasp_map(lever: Array) -> Array:
    """Grasp map G with wrench = G f, [force; moment] (right-hand sides of Xue et al., eq. 3).

    Args:
        lever: (..., m, 3) contact points relative to the moment's reference point [m].

    Returns:
        (..., 6, 3 m): three identity blocks over [lever]x, forces stacked contact by contact
        in the frame of ``lever``.
    """
    r = np.asarray(lever, dtype=float)
    count = r.shape[-2]
    blocks = np.empty((*r.shape[:-2], 6, count, 3))
    blocks[..., :3, :, :] = np.eye(3)[:, None, :]
    blocks[..., 3:, :, :] = np.swapaxes(skew(r), -3, -2)
    return blocks.reshape(*r.shape[:-2], 6, 3 * count)
