"""A turning tool from a curve of quaternions."""

from __future__ import annotations

import numpy as np

from pivotgait.control.curves import quintic_spline
from pivotgait.frozen import Array
from pivotgait.plans import ToolMotion


def quaternion_curve(time: Array, tool: ToolMotion) -> Array:
    """(N - 1, 6, 4) coefficients of the spline through the tool's quaternions xyzw.

    Signs are chosen so that neighbours are near; between samples the norm is one only to the
    order of the spline, which :func:`turning` accounts for.

    Args:
        time: (N,) [s].
        tool: N samples.
    """
    quaternions = tool.orientation.copy()
    flips = np.sign(np.einsum("ni,ni->n", quaternions[1:], quaternions[:-1]))
    quaternions[1:] *= np.cumprod(np.where(flips < 0.0, -1.0, 1.0))[:, None]
    rates = 0.5 * _product(tool.angular_velocity, quaternions)
    accelerations = 0.5 * (
        _product(tool.angular_acceleration, quaternions) + _product(tool.angular_velocity, rates)
    )
    return quintic_spline(time, quaternions, rates, accelerations)


def turning(curve: Array) -> tuple[Array, Array, Array]:
    """Rotation, angular velocity and acceleration of a curve of quaternions p, not of unit norm.

    With n = |p|^2: omega = 2 Im(dp/dt p*) / n and alpha = 2 Im(d2p/dt2 p*) / n - omega dn/dt / n.

    Args:
        curve: (3, 4) p, xyzw, and its first two derivatives.

    Returns:
        (3, 3) world <- tool, (3,) [rad/s] and (3,) [rad/s^2] in world axes.
    """
    (x, y, z, w), (dx, dy, dz, dw), (ddx, ddy, ddz, ddw) = curve.tolist()
    norm = x * x + y * y + z * z + w * w
    s = 2.0 / norm
    rotation = np.array(
        (
            (1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)),
            (s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)),
            (s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)),
        )
    )
    omega_x = s * (w * dx - x * dw - (dy * z - dz * y))
    omega_y = s * (w * dy - y * dw - (dz * x - dx * z))
    omega_z = s * (w * dz - z * dw - (dx * y - dy * x))
    growth = s * (x * dx + y * dy + z * dz + w * dw)
    acceleration = (
        s * (w * ddx - x * ddw - (ddy * z - ddz * y)) - growth * omega_x,
        s * (w * ddy - y * ddw - (ddz * x - ddx * z)) - growth * omega_y,
        s * (w * ddz - z * ddw - (ddx * y - ddy * x)) - growth * omega_z,
    )
    return rotation, np.array((omega_x, omega_y, omega_z)), np.array(acceleration)


def _product(vector: Array, quaternion: Array) -> Array:
    """(N, 4) products of pure quaternions (N, 3) with quaternions (N, 4), xyzw."""
    imaginary, real = quaternion[:, :3], quaternion[:, 3:]
    vectors = real * vector + np.cross(vector, imaginary)
    scalars = -np.einsum("ni,ni->n", vector, imaginary)
    return np.column_stack((vectors, scalars))
