"""What holds joints back: accelerations that were asked for and did not come."""

from __future__ import annotations

import numpy as np

from pivotgait.frozen import Array

TIME_CONSTANT_S = 0.01
"""Of the average: some cycles of control, and short beside a phase [s]."""


class Resistance:
    """Asked less measured accelerations, averaged: dry friction and what else no model knows.

    A distal joint of a hand weighs so little (3e-6 kg m^2) that friction of 5 mN m holds it
    against 1,500 rad/s^2. Limits are about the joint's real motion: without this, those of its
    speed forbid the torque that would move it at all, and it lags behind until it collides.

    Attributes:
        acceleration: (n,) resisted [rad/s^2] or [m/s^2].
    """

    def __init__(self, size: int) -> None:
        """Nothing known of ``size`` joints."""
        self.acceleration = np.zeros(size)
        self.reset()

    def reset(self) -> None:
        """Forget what was asked."""
        self.acceleration[:] = 0.0
        self._last: tuple[float, Array, Array] | None = None

    def observe(self, time: float, v: Array) -> None:
        """Compare the speeds ``v`` (n,) at ``time`` [s] with what was asked of them before."""
        if self._last is None:
            return
        before, v_before, asked = self._last
        passed = time - before
        if passed <= 0.0:
            return
        missing = asked - (v - v_before) / passed
        share = min(passed / TIME_CONSTANT_S, 1.0)
        self.acceleration += share * (missing - self.acceleration)

    def ask(self, time: float, v: Array, acceleration: Array) -> None:
        """Note the accelerations (n,) asked for at ``time`` [s] and speeds ``v`` (n,)."""
        self._last = (time, v, acceleration)
