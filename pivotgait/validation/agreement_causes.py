"""Why two engines differ: both again with one thing changed, and what closes the gap."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from pivotgait.validation.agreement import Agreement, Gap, gap_json
from pivotgait.validation.simulator import SimulatorOptions

CLOSES = 0.5
"""A change is a likely cause if it leaves at most this share of the gap."""


def _halved(options: SimulatorOptions) -> SimulatorOptions:
    return replace(options, step_s=0.5 * options.step_s)


def _harder(options: SimulatorOptions) -> SimulatorOptions:
    return replace(options, contact_stiffness=None)


def _square(options: SimulatorOptions) -> SimulatorOptions:
    return replace(options, friction_cone="pyramidal")


def _longer(options: SimulatorOptions) -> SimulatorOptions:
    return replace(options, solver_iterations=4 * options.solver_iterations)


CHANGES: Mapping[str, Callable[[SimulatorOptions], SimulatorOptions]] = MappingProxyType(
    {
        "step halved": _halved,
        "hard contacts": _harder,
        "pyramidal friction cone": _square,
        "four times the solver's iterations": _longer,
    }
)
"""What is changed in both engines at once, the controller's period staying as it is."""


@dataclass(frozen=True)
class Attempt:
    """Both engines with one thing changed.

    Attributes:
        change: its name.
        gap: the same quantity, phase and part as the gap looked into; None if not both runs
            came there.
        largest: gap of this comparison.
        share_within: its score.
        same_verdict: as :attr:`Agreement.same_verdict`.
    """

    change: str
    gap: Gap | None
    largest: Gap
    share_within: float
    same_verdict: bool


@dataclass(frozen=True)
class Causes:
    """What was tried to close the largest gap of a comparison.

    Attributes:
        gap: looked into.
        attempts: in the order of :data:`CHANGES`.
    """

    gap: Gap
    attempts: tuple[Attempt, ...]

    @property
    def likely(self) -> Attempt | None:
        """The attempt that closes the gap best, if it leaves at most half of it."""
        known = [each for each in self.attempts if each.gap is not None and each.same_verdict]
        best = min(known, key=lambda each: _ratio(each), default=None)
        return best if best is not None and _ratio(best) <= CLOSES * self.gap.ratio else None

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        likely = self.likely
        return {
            "gap": gap_json(self.gap),
            "likely": likely.change if likely else None,
            "attempts": [
                {
                    "change": each.change,
                    "gap": gap_json(each.gap) if each.gap else None,
                    "largest_gap": gap_json(each.largest),
                    "share_within": each.share_within,
                    "same_verdict": each.same_verdict,
                }
                for each in self.attempts
            ],
        }


def look_for_cause(
    found: Agreement,
    engine: SimulatorOptions,
    again: Callable[[SimulatorOptions], Agreement],
    *,
    progress: Callable[[str], None] | None = None,
) -> Causes:
    """Repeat a comparison with each of :data:`CHANGES` and watch its largest gap.

    Args:
        found: the comparison.
        engine: options it was made with.
        again: makes it with other options.
        progress: called with the name of each change that has been tried.
    """
    attempts = []
    for name, change in CHANGES.items():
        other = again(change(engine))
        gap = other.gap_of(found.gap)
        attempts.append(Attempt(name, gap, other.gap, other.share_within, other.same_verdict))
        if progress:
            progress(name)
    return Causes(found.gap, tuple(attempts))


def _ratio(attempt: Attempt) -> float:
    return attempt.gap.ratio if attempt.gap else float("inf")
