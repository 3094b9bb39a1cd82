"""Contact frames: z along the inward normal, x and y spanning the tangent plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def contact_frame(normal: Array) -> Array:
    """Orthonormal frames whose third axis is the normal.

    The frame is continuous in the normal except at n_z = -1 (Duff et al., "Building an
    Orthonormal Basis, Revisited", JCGT 2017, with the sign kept by the branch on n_z).

    Args:
        normal: (..., 3) unit inward normals in any frame A.

    Returns:
        (..., 3, 3) right-handed rotations ``aRcontact`` with columns (t_x, t_y, n).
    """
    n = np.asarray(normal, dtype=float)
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    t_x = np.stack((1.0 + sign * x * x * a, sign * b, -sign * x), axis=-1)
    t_y = np.stack((b, sign + y * y * a, -y), axis=-1)
    return np.stack((t_x, t_y, n), axis=-1)
