"""The plan's time during a run: it may be slowed, stopped and turned back, without jumps."""

from __future__ import annotations

from pivotgait.control.pace import Pace
from pivotgait.control.reference import Instant, Reference
from pivotgait.control.tool_state import ToolState

PACE_CHANGE = 20.0
"""Largest |d2s/dt2| [1/s]: from forwards to backwards in 0.1 s."""
_AS_PLANNED = Pace(1.0)


class PlanClock:
    """Integrates the pace; while it stays as planned, the plan's time is the run's, bit for bit.

    Attributes:
        wanted_speed: ds/dt that the clock moves towards.
        pace: now.
        lag: of the plan's time behind the run's [s].
    """

    def __init__(self) -> None:
        """A clock that goes as planned."""
        self.reset()

    def reset(self) -> None:
        """Start anew."""
        self.wanted_speed, self.pace, self.lag = 1.0, _AS_PLANNED, 0.0
        self._last: float | None = None

    def plan_time(self, time: float) -> float:
        """The plan's time [s] at the run's time of the last cycle, ``time`` [s]."""
        return time - self.lag

    def advance(self, time: float) -> None:
        """Go on to the run's ``time`` [s]."""
        step = 0.0 if self._last is None else time - self._last
        self._last = time
        before = self.pace.speed
        missing = self.wanted_speed - before
        if missing == 0.0 or step <= 0.0:
            if self.pace.change != 0.0:
                self.pace = Pace(before)
            self.lag += (1.0 - before) * step
            return
        speed = before + max(min(missing, PACE_CHANGE * step), -PACE_CHANGE * step)
        self.pace = Pace(speed, (speed - before) / step)
        self.lag += (1.0 - 0.5 * (before + speed)) * step

    def stop_at(self, time: float, plan_time: float) -> None:
        """Stand at ``plan_time`` [s], where the path itself must be at rest."""
        self.lag, self.wanted_speed, self.pace = time - plan_time, 0.0, Pace(0.0)

    def instant(self, reference: Reference, time: float) -> Instant:
        """What the plan wants now, with rates by the run's time."""
        wanted, pace = reference.at(self.plan_time(time)), self.pace
        return wanted if pace is _AS_PLANNED or pace == _AS_PLANNED else paced(wanted, pace)


def paced(wanted: Instant, pace: Pace) -> Instant:
    """An instant of the plan whose time passes at a pace of its own."""
    q, v, a = pace.rates(wanted.q, wanted.v, wanted.a)
    tool = wanted.tool
    position = pace.rates(tool.position, tool.linear_velocity, tool.linear_acceleration)
    turning = pace.rates(tool.rotation, tool.angular_velocity, tool.angular_acceleration)
    moved = ToolState(
        position=position[0],
        rotation=turning[0],
        linear_velocity=position[1],
        angular_velocity=turning[1],
        linear_acceleration=position[2],
        angular_acceleration=turning[2],
    )
    return wanted._replace(tool=moved, q=q, v=v, a=a, pace=pace)
