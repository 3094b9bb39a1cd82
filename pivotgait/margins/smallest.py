"""The verdict on margins: the smallest one, of which kind, where and when."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from pivotgait.frozen import Array
from pivotgait.margins.gait import ContactMargins, PhaseMargins, gait_margins
from pivotgait.plans.plan import PIVOT, GaitPlan

MarginKind = Literal["friction", "lift_off", "normal_min", "normal_max"]
MARGIN_KINDS: tuple[MarginKind, ...] = ("friction", "lift_off", "normal_min", "normal_max")
PHYSICAL: tuple[MarginKind, ...] = ("friction", "lift_off")
"""Margins against losing a contact. The bounds of a finger's force are a choice of the user, and
an allocation that squeezes as hard as it may touches them without any danger."""


@dataclass(frozen=True)
class Margin:
    """A margin at one contact and time.

    Attributes:
        kind: friction, lift_off (pivot above its least normal force), normal_min or normal_max.
        contact: name of the contact.
        phase: name of the phase.
        time_s: from the phase's start [s].
        value: dimensionless, so that kinds compare: the friction margin itself, or the distance
            from the bound as a share of the distance between the two bounds. Negative when
            violated.
    """

    kind: MarginKind
    contact: str
    phase: str
    time_s: float
    value: float

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        return asdict(self)


def smallest_margin(plan: GaitPlan, kinds: Iterable[MarginKind] = PHYSICAL) -> Margin | None:
    """Smallest margin of a plan among ``kinds``, the earliest of equals.

    Returns:
        The margin, or None if no contact has one (all free of force).
    """
    wanted = tuple(kinds)
    found = (smallest_of_phase(phase, wanted) for phase in gait_margins(plan))
    return min((each for each in found if each), key=lambda each: each.value, default=None)


def smallest_of_phase(
    margins: PhaseMargins, kinds: Iterable[MarginKind] = PHYSICAL
) -> Margin | None:
    """Smallest margin of a phase among ``kinds``, or None if no contact has one."""
    wanted = tuple(kinds)
    best: Margin | None = None
    for contact in margins.contacts.values():
        for kind, values in _series(contact):
            if kind not in wanted or np.all(np.isnan(values)):
                continue
            k = int(np.nanargmin(values))
            least = float(values[k])
            if best is None or least < best.value:
                time = float(margins.time[k])
                best = Margin(kind, contact.name, margins.phase, time, least)
    return best


def _series(contact: ContactMargins) -> Iterator[tuple[MarginKind, Array]]:
    yield "friction", contact.friction
    # Equal bounds leave no room to speak of a share; the distance itself is 0 inside them.
    scale = contact.span if contact.span > 0.0 else 1.0
    lower: MarginKind = "lift_off" if contact.name == PIVOT else "normal_min"
    yield lower, contact.above_min / scale
    yield "normal_max", contact.below_max / scale
