"""What is said of two runs of one plan in two engines: differences, a score, a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pivotgait.validation.contact_events import ContactEvent
from pivotgait.validation.tolerance_check import check_tolerances
from pivotgait.validation.verdict import Verdict

PASSED, NOT_REACHED = "passed", "not reached"
"""What a stage's verdict may be besides the class of a failure."""


@dataclass(frozen=True)
class Tolerances:
    """Differences between two engines up to which they count as agreeing.

    They say what a user of the plan would call the same, not what rounding allows: a tenth of a
    newton is the accuracy asked of the force control, 20 ms is the longest loss of contact that
    the verdict's rule forgives, and millimetre and degree are a third and a fifth of what it
    allows before a run has failed.

    Attributes:
        normal_force_N: of a finger's normal force: RMS over a phase, or at an instant.
        position_mm: of the tool's centre of mass, largest in a phase.
        orientation_deg: of the tool, largest in a phase.
        tip_slip_mm: of the way of the tip on the table, largest in a phase.
        fingertip_slip_mm: of the way of a fingertip along the tool, largest in a phase.
        timing_ms: of a contact's make or break.
    """

    normal_force_N: float = 0.1
    position_mm: float = 1.0
    orientation_deg: float = 1.0
    tip_slip_mm: float = 1.0
    fingertip_slip_mm: float = 1.0
    timing_ms: float = 20.0

    def __post_init__(self) -> None:
        check_tolerances(self)


@dataclass(frozen=True)
class Gap:
    """A difference over its tolerance: 1 is just tolerated.

    Attributes:
        quantity: name of the tolerance.
        phase: in which it is.
        part: finger, or empty for the tool.
        value: the difference, in the tolerance's unit.
        ratio: to the tolerance; infinite for a contact that only one engine made.
    """

    quantity: str
    phase: str
    part: str
    value: float
    ratio: float


@dataclass(frozen=True)
class PhaseAgreement:
    """One stage in both engines.

    Attributes:
        name: of the phase, or of the final hold.
        verdicts: in each engine: ``passed``, ``not reached`` or the class of the failure.
        normal_force_rms_N: of the difference, by finger that has business at the tool.
        position_mm: largest difference.
        orientation_deg: largest difference.
        tip_slip_mm: largest in each engine, and largest difference.
        fingertip_slip_mm: the same by finger.
        contact: made or broken in this phase, as each engine did it; None if there is none.
        share_within: of the time during which all differences are within tolerance.
    """

    name: str
    verdicts: tuple[str, str]
    normal_force_rms_N: Mapping[str, float]
    position_mm: float
    orientation_deg: float
    tip_slip_mm: tuple[float, float, float]
    fingertip_slip_mm: Mapping[str, tuple[float, float, float]]
    contact: tuple[ContactEvent, ContactEvent] | None
    share_within: float

    @property
    def timing_ms(self) -> float | None:
        """By how much the contact's times differ; None without a contact that both had."""
        if self.contact is None or None in (times := [each.actual_s for each in self.contact]):
            return None
        return 1e3 * abs(float(times[0] or 0.0) - float(times[1] or 0.0))

    def gaps(self, tolerances: Tolerances) -> tuple[Gap, ...]:
        """Every difference over its tolerance."""
        found = [("normal_force_N", f, v) for f, v in self.normal_force_rms_N.items()]
        found += [("position_mm", "", self.position_mm)]
        found += [("orientation_deg", "", self.orientation_deg)]
        found += [("tip_slip_mm", "", self.tip_slip_mm[2])]
        found += [("fingertip_slip_mm", f, v[2]) for f, v in self.fingertip_slip_mm.items()]
        if self.contact is not None:
            times = [each.actual_s is None for each in self.contact]
            alone = float("inf") if any(times) and not all(times) else 0.0
            apart = alone if self.timing_ms is None else self.timing_ms
            found += [("timing_ms", self.contact[0].finger, apart)]
        return tuple(
            Gap(quantity, self.name, part, value, value / getattr(tolerances, quantity))
            for quantity, part, value in found
        )


@dataclass(frozen=True)
class Agreement:
    """Two engines on one plan.

    The **score** is :attr:`share_within`: the share of the time, from the plan's start to the end
    of the shorter run, during which normal force of every finger, position, orientation and all
    slips differ by no more than their tolerances, all at once. 1 means that at no instant would a
    user have seen two different runs. Beside it stands the **largest gap**: the largest difference
    of any phase (forces as RMS over the phase, the rest as maxima, timings of contacts included)
    over its tolerance. The engines *agree* if their verdicts are the same and that ratio is at
    most 1; momentary differences of force do not prevent it.

    Attributes:
        simulators: names.
        controller: name.
        verdicts: of the rule on each run.
        tolerances: that were applied.
        phases: that both runs came to, in order.
        share_within: the score.
    """

    simulators: tuple[str, str]
    controller: str
    verdicts: tuple[Verdict, Verdict]
    tolerances: Tolerances
    phases: tuple[PhaseAgreement, ...]
    share_within: float

    @property
    def gap(self) -> Gap:
        """The largest."""
        every = [gap for phase in self.phases for gap in phase.gaps(self.tolerances)]
        return max(every, key=lambda gap: gap.ratio)

    @property
    def same_verdict(self) -> bool:
        """Whether both passed, or both failed by the same class in the same stage."""
        one, two = ((each.passed, each.failure, each.stage) for each in self.verdicts)
        return one == two

    @property
    def agrees(self) -> bool:
        """Same verdict, and no gap beyond its tolerance."""
        return self.same_verdict and self.gap.ratio <= 1.0

    def gap_of(self, gap: Gap) -> Gap | None:
        """The same quantity, phase and part here; None if this comparison did not come there."""
        for phase in self.phases:
            for each in phase.gaps(self.tolerances):
                if (each.quantity, each.phase, each.part) == (gap.quantity, gap.phase, gap.part):
                    return each
        return None

    def as_json(self) -> dict[str, Any]:
        """Plain data; what is infinite is None."""
        phases = []
        for phase in self.phases:
            known = [value for value in (phase.timing_ms,) if value is not None]
            phases.append(asdict(phase) | {"timing_ms": known[0] if known else None})
        return {
            "simulators": list(self.simulators),
            "controller": self.controller,
            "verdicts": [asdict(each) for each in self.verdicts],
            "same_verdict": self.same_verdict,
            "agrees": self.agrees,
            "share_within": self.share_within,
            "largest_gap": gap_json(self.gap),
            "tolerances": asdict(self.tolerances),
            "phases": phases,
        }


def gap_json(gap: Gap) -> dict[str, Any]:
    """Plain data; what is infinite is None."""
    return {
        key: None if isinstance(value, float) and not np.isfinite(value) else value
        for key, value in asdict(gap).items()
    }
