"""A removal that is run backwards while its grasp is in danger, and tried again."""

from __future__ import annotations

from pivotgait.control.plan_clock import PlanClock
from pivotgait.control.recovery_event import RecoveryEvent
from pivotgait.control.recovery_options import RecoveryOptions
from pivotgait.control.reference import PhaseReference
from pivotgait.control.threshold import Threshold

LEAVING_S = 0.05
"""Until so long after a removal's end its finger still touches and may come back [s]."""

_AFTER_SEAM_S = 1e-6
"""The clock stands so long after a removal's start, so that it still belongs to it [s]."""


class PutBack:
    """Turns the plan's clock back while a removal's margin is too small.

    The clock runs back to the removal's start, where everything is at rest; it stands there for a
    while, and goes on more slowly. A removal that fails again ends the run in the grasp before it.
    Half-way back margins rise as soon as the finger presses again, and fall as soon as it leaves.

    Attributes:
        given_up_s: when the clock was stopped for good, run's time [s]; None if it was not.
        events: so far.
    """

    def __init__(
        self, clock: PlanClock, removals: tuple[PhaseReference, ...], options: RecoveryOptions
    ) -> None:
        """Of a plan's removals."""
        self._clock, self._options = clock, options
        self._removals = removals
        self._danger = Threshold(options.put_back_below, options.hysteresis, options.lasting_s)
        self.reset()

    def reset(self) -> None:
        """Start anew."""
        self._danger.reset()
        self.events: list[RecoveryEvent] = []
        self.given_up_s: float | None = None
        self._removal: PhaseReference | None = None
        self._tries = 0
        self._turned_back = False
        self._rest_from: float | None = None

    @property
    def active(self) -> bool:
        """Whether a removal is run backwards, stands or is tried again."""
        return self._removal is not None

    def update(self, time: float, name: str, margin: float) -> None:
        """Decide how the clock goes on.

        Args:
            time: of the run [s].
            name: of what has the least margin.
            margin: the least one.
        """
        if self.given_up_s is not None:
            return
        at = self._clock.plan_time(time)
        if self._turned_back:
            self._go_back(time, at, name, margin)
            return
        removal = next((r for r in self._removals if _runs(r, at)), None)
        if removal is not self._removal and self._removal is not None:
            self._completed(time, margin)
        if removal is None:
            self._danger.reset()
        elif self._danger.update(margin, time):
            self._turn_back(removal, time, name, margin)

    def _turn_back(self, removal: PhaseReference, time: float, name: str, margin: float) -> None:
        if self._removal is not None:
            self._end(time, margin)
        self._removal, self._turned_back, self._rest_from = removal, True, None
        self._clock.wanted_speed = -1.0
        self.events.append(RecoveryEvent("put back", name, time, margin))

    def _go_back(self, time: float, at: float, name: str, margin: float) -> None:
        removal, last = self._removal, self._tries >= self._options.retries
        assert removal is not None
        start = removal.start + _AFTER_SEAM_S
        if at <= start and self._clock.pace.speed < 0.0:
            self._clock.stop_at(time, start)
        if self._rest_from is not None:
            if time - self._rest_from >= self._options.settle_s and self._clock.pace.speed == 0.0:
                self._try_again(time, name, margin)
            return
        if at > start:
            return
        self._rest_from = time
        self._end(time, margin)
        if last:
            self.given_up_s = time
            self.events.append(RecoveryEvent("give up", name, time, margin))

    def _try_again(self, time: float, name: str, margin: float) -> None:
        self._tries += 1
        self._turned_back = False
        self._danger.reset()
        self._clock.wanted_speed = self._options.retry_speed
        self.events.append(RecoveryEvent("try again", name, time, margin))

    def _completed(self, time: float, margin: float) -> None:
        self._end(time, margin)
        self._clock.wanted_speed = 1.0
        self._removal, self._tries = None, 0

    def _end(self, time: float, margin: float) -> None:
        self.events[-1].end_s, self.events[-1].margin_after = time, margin


def _runs(removal: PhaseReference, time: float) -> bool:
    """Whether a removal's finger is leaving at the plan's ``time`` [s]."""
    return removal.start < time < removal.start + removal.duration + LEAVING_S
