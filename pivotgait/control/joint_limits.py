"""Bounds of joint accelerations that keep positions and speeds within their limits."""

from __future__ import annotations

import numpy as np

from pivotgait.frozen import Array
from pivotgait.models import Robot

HORIZON = 0.02
"""A joint may not be past its limit after this time [s] of steady acceleration."""
REACTION = 0.002
"""A joint may not be faster than its limit after this time [s]."""


class JointLimits:
    """Limits of a robot's joints, as bounds of accelerations.

    Attributes:
        effort: (n,) largest torques [N m] or forces [N].
    """

    def __init__(self, robot: Robot) -> None:
        """The limits of ``robot``."""
        self.effort = robot.effort_max
        self._lower, self._upper = robot.lower, robot.upper
        self._speed = robot.velocity_max

    def acceleration_bounds(self, q: Array, v: Array) -> tuple[Array, Array]:
        """(n,) least and largest accelerations; beyond a limit they lead back.

        Args:
            q: (n,) positions [rad] or [m].
            v: (n,) velocities [rad/s] or [m/s].
        """
        ahead, square = q + HORIZON * v, 2.0 / HORIZON**2
        upper = np.minimum((self._upper - ahead) * square, (self._speed - v) / REACTION)
        lower = np.maximum((self._lower - ahead) * square, (-self._speed - v) / REACTION)
        return np.minimum(lower, upper), upper
