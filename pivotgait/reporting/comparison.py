"""What the page says of a plan in two engines: how far they agree, and why not farther."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pydantic import BaseModel, FiniteFloat, ValidationError

from pivotgait.exceptions import InputError
from pivotgait.reporting.numbers import UNKNOWN, number, quantity
from pivotgait.reporting.verdict import engine_name

_MEANINGS = MappingProxyType(
    {
        "normal_force_N": ("normal force, RMS difference", "N"),
        "position_mm": ("position of the tool", "mm"),
        "orientation_deg": ("orientation of the tool", "°"),
        "tip_slip_mm": ("slip of the tip", "mm"),
        "fingertip_slip_mm": ("slip of a fingertip", "mm"),
        "timing_ms": ("instant of a contact", "ms"),
    }
)
_COLUMNS = tuple(_MEANINGS)
Slips = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Interval = tuple[FiniteFloat, FiniteFloat]


class _Gap(BaseModel):
    quantity: str
    phase: str
    part: str = ""
    value: FiniteFloat | None = None
    ratio: FiniteFloat | None = None


class _Verdict(BaseModel):
    passed: bool
    failure: str = ""
    stage: str = ""


class _Phase(BaseModel):
    name: str
    verdicts: tuple[str, str]
    normal_force_rms_N: Mapping[str, FiniteFloat]
    position_mm: FiniteFloat
    orientation_deg: FiniteFloat
    tip_slip_mm: Slips
    fingertip_slip_mm: Mapping[str, Slips]
    timing_ms: FiniteFloat | None = None
    share_within: FiniteFloat

    def largest(self) -> tuple[float | None, ...]:
        """In the order of the columns."""
        return (
            max(self.normal_force_rms_N.values(), default=None),
            self.position_mm,
            self.orientation_deg,
            self.tip_slip_mm[2],
            max((each[2] for each in self.fingertip_slip_mm.values()), default=None),
            self.timing_ms,
        )


class _Nominal(BaseModel):
    simulators: tuple[str, str]
    controller: str
    verdicts: tuple[_Verdict, _Verdict]
    same_verdict: bool
    agrees: bool
    share_within: FiniteFloat
    largest_gap: _Gap
    tolerances: Mapping[str, FiniteFloat]
    phases: tuple[_Phase, ...]


class _Attempt(BaseModel):
    change: str
    gap: _Gap | None = None
    share_within: FiniteFloat
    same_verdict: bool


class _Causes(BaseModel):
    gap: _Gap
    likely: str | None = None
    attempts: tuple[_Attempt, ...]


class _Crossed(BaseModel):
    outcomes: tuple[str, str]
    trials: int


class _Trials(BaseModel):
    trials: int
    passed: tuple[int, int]
    wilson_95: tuple[Interval, Interval]
    same_verdict: int
    same_verdict_wilson_95: Interval
    kappa: FiniteFloat | None = None
    crossed: tuple[_Crossed, ...]


class _Found(BaseModel):
    nominal: _Nominal
    causes: _Causes | None = None
    trials: _Trials | None = None


@dataclass(frozen=True)
class PhaseRow:
    """A phase in both engines; texts with units.

    Attributes:
        name: of the phase.
        verdicts: in both, one word if they are the same.
        same: whether they are.
        cells: largest differences in the order of :attr:`EngineComparison.heads`.
        share_within: of the time within all tolerances.
    """

    name: str
    verdicts: str
    same: bool
    cells: tuple[Cell, ...]
    share_within: str


@dataclass(frozen=True)
class Cell:
    """A difference, and whether it is within its tolerance."""

    head: str
    text: str
    within: bool


@dataclass(frozen=True)
class EngineComparison:
    """Everything the page says of a comparison.

    Attributes:
        engines: names as their makers write them.
        agrees: whether all phases are within tolerance and the verdicts are the same.
        sentence: what was found.
        heads: of the differences, with the tolerance of each.
        rows: phases in order.
        cause: what was tried to close the largest gap; empty if nothing was.
        attempts: (change, remaining gap, share within) of each.
        trials: sentence about perturbed trials; empty if there are none.
        crossed: (outcome in one, outcome in the other, number of seeds).
    """

    engines: tuple[str, str]
    agrees: bool
    sentence: str
    heads: tuple[tuple[str, str], ...]
    rows: tuple[PhaseRow, ...]
    cause: str
    attempts: tuple[tuple[str, str, str], ...]
    trials: str
    crossed: tuple[tuple[str, str, int], ...]


def engine_comparison(found: Mapping[str, Any], *, where: str) -> EngineComparison:
    """A comparison from what ``pivotgait compare --json`` said of it.

    Raises:
        InputError: if it does not say enough.
    """
    try:
        told = _Found.model_validate(found)
        one, two = map(engine_name, told.nominal.simulators)
        heads = [
            (_MEANINGS[name][0], _quantity(name, told.nominal.tolerances[name]))
            for name in _COLUMNS
        ]
        sentence = _sentence(told.nominal)
        rows = tuple(_row(phase, told.nominal.tolerances) for phase in told.nominal.phases)
    except (ValidationError, KeyError) as error:
        mend = "write it with 'pivotgait compare -o'"
        raise InputError("is no comparison", where=where, mend=mend) from error
    causes, trials = told.causes, told.trials
    return EngineComparison(
        engines=(one, two),
        agrees=told.nominal.agrees,
        sentence=sentence,
        heads=tuple(heads),
        rows=rows,
        cause=_cause(causes) if causes else "",
        attempts=tuple(map(_attempt, causes.attempts)) if causes else (),
        trials=_trials(trials, (one, two)) if trials else "",
        crossed=tuple((*each.outcomes, each.trials) for each in trials.crossed) if trials else (),
    )


def _sentence(found: _Nominal) -> str:
    one, two = map(engine_name, found.simulators)
    said = [
        f"{name} {'passed' if each.passed else f'failed by {each.failure} in {each.stage}'}"
        for name, each in zip((one, two), found.verdicts, strict=True)
    ]
    share = _percent(found.share_within)
    verdicts = "same verdict" if found.same_verdict else "verdicts differ"
    return (
        f"One plan under {found.controller} control: {said[0]}, {said[1]} ({verdicts}). The score, "
        f"the share of time within all tolerances at once, is {share}. Largest difference: "
        f"{_gap(found.largest_gap)}."
    )


def _gap(gap: _Gap) -> str:
    place = ", ".join(each for each in (gap.part, gap.phase) if each)
    value = _quantity(gap.quantity, gap.value)
    times = "in one engine only" if gap.ratio is None else f"{number(gap.ratio)} of its tolerance"
    return f"{_MEANINGS[gap.quantity][0]} ({place}), {value}, {times}"


def _row(phase: _Phase, tolerances: Mapping[str, float]) -> PhaseRow:
    cells = tuple(
        Cell(
            _MEANINGS[name][0],
            UNKNOWN if value is None else _quantity(name, value),
            value is None or value <= tolerances[name],
        )
        for name, value in zip(_COLUMNS, phase.largest(), strict=True)
    )
    one, two = phase.verdicts
    verdicts = one if one == two else f"{one} / {two}"
    share = _percent(phase.share_within)
    return PhaseRow(phase.name, verdicts, one == two, cells, share)


def _cause(causes: _Causes) -> str:
    if causes.likely is None:
        return "None of the changes that were tried in both engines halves the largest difference."
    return f"Of the changes tried in both engines, this closes it best: {causes.likely}."


def _attempt(attempt: _Attempt) -> tuple[str, str, str]:
    gap = attempt.gap
    left = UNKNOWN if gap is None or gap.ratio is None else number(gap.ratio)
    if not attempt.same_verdict:
        left = f"{left} (verdicts differ)"
    return attempt.change, left, _percent(attempt.share_within)


def _trials(found: _Trials, engines: tuple[str, str]) -> str:
    counts = [
        f"{name} passed {count} of {found.trials} ({_interval(interval)})"
        for name, count, interval in zip(engines, found.passed, found.wilson_95, strict=True)
    ]
    kappa = "" if found.kappa is None else f"; Cohen's kappa {number(found.kappa)}"
    return (
        f"Perturbed trials with the same seeds: {counts[0]}, {counts[1]}. The verdicts agree on "
        f"{found.same_verdict} ({_interval(found.same_verdict_wilson_95)}){kappa}."
    )


def _interval(interval: tuple[float, float]) -> str:
    low, high = (100.0 * each for each in interval)
    return f"95 % confidence {low:.1f} to {high:.1f} %"


def _percent(share: float) -> str:
    """With four digits: the last of them is a few cycles."""
    return quantity(100.0 * share, "%", 4)


def _quantity(name: str, value: float | None) -> str:
    return quantity(value, _MEANINGS[name][1]).replace("\N{NO-BREAK SPACE}°", "°")
