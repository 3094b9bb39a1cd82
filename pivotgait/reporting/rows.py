"""What the page's tables say: one record for each row, every number with its unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pivotgait.certification import LIMITS
from pivotgait.margins import gait_margins, smallest_of_phase
from pivotgait.plans.plan import GaitPlan
from pivotgait.reporting.numbers import UNKNOWN, number, quantity


@dataclass(frozen=True)
class PhaseRow:
    """A phase in the opening table; texts with units."""

    name: str
    kind: str
    finger: str
    duration: str
    plan_time: str
    margin: str
    margin_at: str
    reorientation: str


@dataclass(frozen=True)
class CheckRow:
    """A residual of the certificate beside its limit."""

    what: str
    meaning: str
    value: str
    limit: str
    where: str
    holds: bool


@dataclass(frozen=True)
class ViolationRow:
    """A check that fails."""

    meaning: str
    value: str
    limit: str
    where: str


def phase_rows(plan: GaitPlan, plan_times: Mapping[str, float]) -> tuple[PhaseRow, ...]:
    """The phases in order; ``plan_times`` maps a phase's name to its planning time [s]."""
    rows = []
    for phase, margins in zip(plan.phases, gait_margins(plan), strict=True):
        least = smallest_of_phase(margins, ["friction"])
        rows.append(
            PhaseRow(
                name=phase.name,
                kind=phase.kind,
                finger=phase.finger or UNKNOWN,
                duration=f"{phase.duration_s:.2f}\N{NO-BREAK SPACE}s",
                plan_time=quantity(plan_times.get(phase.name), "s"),
                margin=number(round(least.value, 3)) if least else UNKNOWN,
                margin_at=f"{least.contact}, {quantity(least.time_s, 's')}" if least else "",
                reorientation=f"{phase.reorientation_deg:.1f}°",
            )
        )
    return tuple(rows)


def check_rows(certificate: Mapping[str, Any]) -> tuple[CheckRow, ...]:
    """Every residual of a certificate (as ``pivotgait certify --json`` gives it)."""
    limits, worst = certificate.get("tolerances", {}), certificate.get("worst", {})
    failed = {violation.get("what") for violation in certificate.get("violations", ())}
    return tuple(
        CheckRow(
            what=what,
            meaning=_meaning(what),
            value=quantity(value, _unit(what)),
            limit=_limit(what, limits.get(what)),
            where=_where(worst.get(what, {})),
            holds=what not in failed,
        )
        for what, value in certificate.get("residuals", {}).items()
    )


def violation_rows(certificate: Mapping[str, Any]) -> tuple[ViolationRow, ...]:
    """Every violation of a certificate."""
    return tuple(
        ViolationRow(
            meaning=_meaning(str(violation.get("what", ""))),
            value=quantity(violation.get("value"), _unit(str(violation.get("what", "")))),
            limit=_limit(str(violation.get("what", "")), violation.get("limit")),
            where=_where(violation),
        )
        for violation in certificate.get("violations", ())
    )


def _meaning(what: str) -> str:
    return LIMITS[what].meaning if what in LIMITS else what.replace("_", " ")


def _unit(what: str) -> str:
    return LIMITS[what].unit.replace("^2", "²") if what in LIMITS else ""


def _limit(what: str, bound: object) -> str:
    sign = "≥" if what in LIMITS and LIMITS[what].at_least else "≤"
    text = quantity(bound, _unit(what))
    return text if text == UNKNOWN else f"{sign} {text}"


def _where(place: Mapping[str, Any]) -> str:
    time = quantity(place.get("time_s"), "s")
    part = place.get("contact") or place.get("part")
    parts = (place.get("phase"), part, "" if time == UNKNOWN else time)
    return ", ".join(str(part) for part in parts if part) or "whole plan"
