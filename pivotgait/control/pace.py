"""How fast a plan's time passes: a path that is run slower, stood still on, or backwards."""

from __future__ import annotations

from typing import NamedTuple

from pivotgait.frozen import Array


class Pace(NamedTuple):
    """Derivatives of the plan's time s by the run's time t.

    Attributes:
        speed: ds/dt, 1 as planned, negative backwards.
        change: d2s/dt2 [1/s].
    """

    speed: float
    change: float = 0.0

    def rates(self, value: Array, rate: Array, acceleration: Array) -> tuple[Array, Array, Array]:
        """A path's value and its derivatives by t, from those by s.

        dx/dt = x' ds/dt and d2x/dt2 = x'' (ds/dt)^2 + x' d2s/dt2.
        """
        speed, change = self.speed, self.change
        return value, speed * rate, speed * speed * acceleration + change * rate
