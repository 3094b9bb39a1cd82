"""When a run counts as in danger, and what is done then."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite

from pivotgait.exceptions import InputError


@dataclass(frozen=True)
class RecoveryOptions:
    """Thresholds of :class:`pivotgait.control.recovery.RecoveringController`.

    Margins are those of :class:`pivotgait.control.grasp_monitor.GraspMargins`.

    Attributes:
        reallocate_below: least margin under which forces are allocated anew.
        put_back_below: least margin under which a removal is run backwards; the smaller one.
        cones_put_back: whether friction cones, too, count for putting a finger back; only for force
            sensors whose directions can be trusted to a few degrees, else sound grasps are given
            up.
        hysteresis: by which a margin must rise over its threshold before a measure ends.
        lasting_s: for which a margin must be below or above before anything changes [s].
        orientation_deg: angle from the planned orientation at which the margin is 0 [deg].
        lag_s: time constant of the low pass on force readings [s].
        squeeze: largest normal forces of an allocation over those planned, within the plan's
            bounds.
        ramp_s: time constant with which forces change over [s].
        period_s: between allocations while one is in force [s].
        retries: of a removal that was run backwards.
        retry_speed: of a further try over the planned speed.
        settle_s: at rest before a further try [s].
    """

    reallocate_below: float = 0.4
    put_back_below: float = 0.35
    cones_put_back: bool = False
    hysteresis: float = 0.1
    lasting_s: float = 0.02
    orientation_deg: float = 5.0
    lag_s: float = 0.02
    squeeze: float = 1.6
    ramp_s: float = 0.1
    period_s: float = 0.02
    retries: int = 1
    retry_speed: float = 0.5
    settle_s: float = 0.3

    def __post_init__(self) -> None:
        """Refuse what is no number or out of range."""
        for entry in fields(self):
            value = getattr(self, entry.name)
            margin = entry.name in ("reallocate_below", "put_back_below")
            if not (isfinite(value) and (margin or value >= 0.0)):
                self._refuse(entry.name, "a number from 0")
        for name in ("orientation_deg", "ramp_s", "period_s", "retry_speed"):
            if getattr(self, name) == 0.0:
                self._refuse(name, "a number above 0")
        if self.put_back_below > self.reallocate_below:
            self._refuse("put_back_below", "no more than reallocate_below")
        if self.squeeze < 1.0:
            self._refuse("squeeze", "1 or more")
        if self.retry_speed > 1.0:
            self._refuse("retry_speed", "no more than 1")

    def _refuse(self, name: str, mend: str) -> None:
        raise InputError(f"{name} = {getattr(self, name)}", where="recovery", mend=f"give {mend}")
