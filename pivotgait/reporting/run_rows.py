"""What the page says of a run: its figures beside what they should be and what ends a run."""

from __future__ import annotations

from dataclasses import dataclass, fields
from types import MappingProxyType

from pivotgait.reporting.numbers import UNKNOWN, quantity
from pivotgait.validation.metrics import Metrics
from pivotgait.validation.record_reading import RecordedRun
from pivotgait.validation.verdict import Rule

AIMS = MappingProxyType(
    {
        "holding_force_rms_N": 0.1,
        "loading_force_rms_N": 0.25,
        "orientation_deg": 2.5,
        "tip_slip_mm": 1.2,
        "fingertip_slip_mm": 1.2,
        "torque_share": 1.0,
    }
)
"""How closely a nominal run of a built-in gait is meant to follow, by name of the metric."""
_MEANINGS = MappingProxyType(
    {
        "holding_force_rms_N": ("Normal force of a holding finger, RMS error", "N"),
        "loading_force_rms_N": ("Normal force of a finger that comes or goes, RMS error", "N"),
        "orientation_deg": ("Orientation, largest error", "°"),
        "tip_slip_mm": ("Slip of the tip on the table, largest", "mm"),
        "fingertip_slip_mm": ("Slip of a fingertip on the tool, largest", "mm"),
        "torque_share": ("Torque over the joint's limit, largest", "%"),
    }
)


@dataclass(frozen=True)
class RunRow:
    """A figure of a run; texts with units.

    Attributes:
        meaning: what it measures.
        value: in this run.
        aim: what it should not exceed.
        limit: where a run counts as failed, a dash if nowhere.
        within: whether the value is within the aim.
    """

    meaning: str
    value: str
    aim: str
    limit: str
    within: bool


def run_rows(run: RecordedRun | None, rule: Rule | None = None) -> tuple[RunRow, ...]:
    """The figures of a run; none where nothing ran."""
    if run is None or run.metrics is None:
        return ()
    rule = rule or Rule()
    limits = {
        "orientation_deg": rule.orientation_deg,
        "tip_slip_mm": 1e3 * rule.tip_slip_m,
        "fingertip_slip_mm": 1e3 * rule.fingertip_slip_m,
    }
    names = [each.name for each in fields(Metrics) if each.name in AIMS]
    return tuple(
        RunRow(
            meaning=_MEANINGS[name][0],
            value=_said(name, value := getattr(run.metrics, name)),
            aim=f"≤ {_said(name, AIMS[name])}",
            limit=f"≤ {_said(name, limits[name])}" if name in limits else UNKNOWN,
            within=value <= AIMS[name],
        )
        for name in names
    )


def _said(name: str, value: float) -> str:
    unit = _MEANINGS[name][1]
    text = quantity(100.0 * value if unit == "%" else value, unit)
    return text.replace("\N{NO-BREAK SPACE}°", "°")
