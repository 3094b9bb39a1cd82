"""Quaternion formulae in CasADi symbols."""

from __future__ import annotations

from typing import Any


class Attitude:
    """Quaternion formulae (xyzw) in CasADi symbols."""

    @staticmethod
    def matrix(ca: Any, q: Any) -> Any:
        """Rotation matrix of a unit quaternion."""
        x, y, z, w = q[0], q[1], q[2], q[3]
        return ca.vertcat(
            ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            ca.horzcat(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            ca.horzcat(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )

    @staticmethod
    def product(ca: Any, a: Any, b: Any) -> Any:
        """Hamilton product a b."""
        return ca.vertcat(
            a[3] * b[:3] + b[3] * a[:3] + ca.cross(a[:3], b[:3]),
            a[3] * b[3] - ca.dot(a[:3], b[:3]),
        )

    @staticmethod
    def exponential(ca: Any, turn: Any) -> Any:
        """Quaternion of a rotation vector, as a series in its squared half angle y.

        Smooth at 0, where omega starts and ends; truncated at 3e-14 for y <= 0.04, that is for
        steps below 23 degrees, which :mod:`pivotgait.phases.removal_solving` checks.
        """
        y = ca.dot(turn, turn) / 4
        sinc = 1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72)))
        cosine = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56)))
        return ca.vertcat(sinc * turn / 2, cosine)
