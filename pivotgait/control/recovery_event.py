"""What was done during a run to save a grasp."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any


@dataclass
class RecoveryEvent:
    """One measure from its trigger to its end.

    Attributes:
        measure: ``reallocate``, ``put back``, ``try again`` or ``give up``.
        finger: whose margin was least, ``tool`` for its orientation.
        time_s: of the trigger, since the reference's start [s].
        margin_before: at the trigger.
        end_s: when the measure ended; None if it lasted to the run's end [s].
        margin_after: then, or at the run's end.
    """

    measure: str
    finger: str
    time_s: float
    margin_before: float
    end_s: float | None = None
    margin_after: float | None = None

    def since(self, begin_s: float) -> RecoveryEvent:
        """The event with times since ``begin_s`` [s]."""
        end = None if self.end_s is None else self.end_s - begin_s
        return replace(self, time_s=self.time_s - begin_s, end_s=end)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)
