"""Angles of the local coordinates xi and their rates (Xue et al., Section V).

The orientation of a contact frame C in its target frame T is

    R_TC = R_x(phi) R_y(psi) R_z(theta),

theta about the contact normal. Angles are stacked in the order of xi: (theta, psi, phi).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array

SMALLEST_COS_PSI = 0.02
"""Below this cosine (psi within 1.15 degrees of +-90) the rates of theta and phi blow up."""

Scalar = TypeVar("Scalar", float, Array)
Entries = tuple[tuple[Scalar, Scalar, Scalar], ...]


def rotation_from_angles(angles: Array) -> Array:
    """R_TC = R_x(phi) R_y(psi) R_z(theta).

    Args:
        angles: (..., 3) theta, psi, phi [rad].

    Returns:
        (..., 3, 3) rotations, T <- C.
    """
    sines, cosines = np.sin(angles), np.cos(angles)
    s_t, s_p, s_f = (sines[..., k] for k in range(3))
    c_t, c_p, c_f = (cosines[..., k] for k in range(3))
    return _stacked(
        (
            (c_p * c_t, -c_p * s_t, s_p),
            (c_f * s_t + s_f * s_p * c_t, c_f * c_t - s_f * s_p * s_t, -s_f * c_p),
            (s_f * s_t - c_f * s_p * c_t, s_f * c_t + c_f * s_p * s_t, c_f * c_p),
        )
    )


def angles_from_rotation(rotation: Array) -> Array:
    """(..., 3) theta, psi, phi [rad] of rotations (..., 3, 3), T <- C.

    theta and phi lie in [-pi, pi], psi inside (-pi/2, pi/2).

    Raises:
        SingularCoordinatesError: where cos(psi) < ``SMALLEST_COS_PSI``.
    """
    r = np.asarray(rotation, dtype=float)
    cos_psi = np.hypot(r[..., 1, 2], r[..., 2, 2])
    psi = np.arctan2(r[..., 0, 2], cos_psi)
    if np.any(cos_psi < SMALLEST_COS_PSI):
        raise SingularCoordinatesError(float(np.max(np.abs(psi))))
    theta = np.arctan2(-r[..., 0, 1], r[..., 0, 0])
    phi = np.arctan2(-r[..., 1, 2], r[..., 2, 2])
    return np.stack((theta, psi, phi), axis=-1)


def rate_map(angles: Array) -> Array:
    """E with d/dt (theta, psi, phi) = E omega (E_i of Xue et al., eqs 11 and 13).

    Args:
        angles: (..., 3) theta, psi, phi [rad].

    Returns:
        (..., 3, 3); omega is the angular velocity of C relative to T, in T axes [rad/s].
    """
    psi, phi = angles[..., 1], angles[..., 2]
    cos_psi = np.cos(psi)
    return _stacked(rate_entries(np.sin(phi), np.cos(phi), np.tan(psi), 1.0 / cos_psi))


def rate_map_derivative(angles: Array, rates: Array) -> Array:
    """Time derivative of :func:`rate_map` along a motion.

    Args:
        angles: (..., 3) theta, psi, phi [rad].
        rates: (..., 3) their time derivatives [rad/s].

    Returns:
        (..., 3, 3) [1/s].
    """
    psi, phi = angles[..., 1], angles[..., 2]
    sin, cos, tan, sec = np.sin(phi), np.cos(phi), np.tan(psi), 1.0 / np.cos(psi)
    sin_rate, cos_rate = cos * rates[..., 2], -sin * rates[..., 2]
    sec_rate, tan_rate = sec * tan * rates[..., 1], sec * sec * rates[..., 1]
    zero = np.zeros_like(sin)
    return _stacked(
        (
            (zero, -sin_rate * sec - sin * sec_rate, cos_rate * sec + cos * sec_rate),
            (zero, cos_rate, sin_rate),
            (zero, sin_rate * tan + sin * tan_rate, -cos_rate * tan - cos * tan_rate),
        )
    )


def rate_map_drift(
    tan_psi: float, sec_psi: float, rates: Sequence[float]
) -> tuple[float, float, float]:
    """dE/dt omega [rad/s^2] of one frame, in terms of the rates E omega alone.

    Equal to ``rate_map_derivative(angles, rates) @ omega``: E takes omega to the rates, so that
    the product is quadratic in them.

    Args:
        tan_psi: tangent of psi.
        sec_psi: 1 / cos(psi).
        rates: of theta, psi, phi [rad/s].
    """
    theta, psi, phi = rates
    return (
        psi * (tan_psi * theta - sec_psi * phi),
        phi * theta / sec_psi,
        psi * (tan_psi * phi - sec_psi * theta),
    )


def rate_entries(
    sin_phi: Scalar, cos_phi: Scalar, tan_psi: Scalar, sec_psi: Scalar
) -> Entries[Scalar]:
    """Rows of E, for floats (fast) or arrays."""
    zero = 0.0 * sin_phi
    return (
        (zero, -sin_phi * sec_psi, cos_phi * sec_psi),
        (zero, cos_phi, sin_phi),
        (zero + 1.0, sin_phi * tan_psi, -cos_phi * tan_psi),
    )


def _stacked(entries: Entries[Array]) -> Array:
    return np.stack([np.stack(row, axis=-1) for row in entries], axis=-2)
