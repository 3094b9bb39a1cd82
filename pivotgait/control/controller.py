"""The contract of every control law."""

from __future__ import annotations

from typing import Protocol

from pivotgait.control.measurement import Measurement
from pivotgait.frozen import Array


class Controller(Protocol):
    """Turns readings into joint torques, one cycle after another.

    A law may keep a state (an integral, a warm start); ``reset`` forgets it, so that two runs
    of equal readings give equal torques, bit for bit.
    """

    def reset(self) -> None:
        """Start anew, before the first cycle of a run."""

    def torque(self, measurement: Measurement) -> Array:
        """(n,) joint torques [N m] or forces [N]; the caller may keep the array."""
