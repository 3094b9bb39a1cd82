"""Margins of every contact over the time of a phase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pivotgait.contacts.cone import friction_margin, split_force
from pivotgait.frozen import Array, frozen
from pivotgait.plans.plan import PIVOT, ContactTrack, GaitPlan, Phase

LEAST_FORCE_N = 1e-3
"""A normal force below this has no meaningful direction, hence no friction margin."""


@dataclass(frozen=True, eq=False)
class ContactMargins:
    """Margins of one contact at the N samples of a phase; all arrays read-only.

    Attributes:
        name: of the contact.
        friction: (N,) 1 - |f_t| / (mu f_n), in [0, 1] inside the cone; NaN without force. Of a soft
            fingertip 1 - |(f_t, mu m / e)| / (mu f_n), with its moment m.
        above_min: (N,) normal force over its lower bound [N]; for the pivot, how far the tip is
            from lifting off the table. NaN for a finger that is being removed or added, and for
            the pivot of a transfer: its force passes through 0 on purpose.
        below_max: (N,) upper bound over the normal force [N].
        span: distance of the two bounds [N].
    """

    name: str
    friction: Array
    above_min: Array
    below_max: Array
    span: float


@dataclass(frozen=True, eq=False)
class PhaseMargins:
    """Margins of a phase.

    Attributes:
        phase: its name.
        time: (N,) from the phase's start [s].
        contacts: by name.
    """

    phase: str
    time: Array
    contacts: Mapping[str, ContactMargins]

    @property
    def lift_off(self) -> Array:
        """(N,) margin of the pivot against lifting off the table [N]."""
        return self.contacts[PIVOT].above_min


def gait_margins(plan: GaitPlan) -> tuple[PhaseMargins, ...]:
    """Margins of every phase, in order."""
    return tuple(phase_margins(phase) for phase in plan.phases)


def phase_margins(phase: Phase) -> PhaseMargins:
    """Margins of every contact of a phase."""
    contacts = {
        name: _contact_margins(contact, phase) for name, contact in sorted(phase.contacts.items())
    }
    return PhaseMargins(phase.name, frozen(phase.time), MappingProxyType(contacts))


def _contact_margins(contact: ContactTrack, phase: Phase) -> ContactMargins:
    normal = contact.world_normal(phase.tool)
    pressing, _ = split_force(contact.force, normal)
    friction = friction_margin(contact.force, normal, contact.friction)
    if contact.moment is not None:
        friction = 1.0 - np.hypot(1.0 - friction, _spin_share(contact, pressing))
    above_min = pressing - contact.normal_min
    changing = phase.kind in ("removal", "addition") and contact.name == phase.finger
    if changing or (phase.kind == "transfer" and contact.is_pivot):
        above_min = np.full_like(above_min, np.nan)
    return ContactMargins(
        name=contact.name,
        friction=frozen(np.where(pressing > LEAST_FORCE_N, friction, np.nan)),
        above_min=frozen(above_min),
        below_max=frozen(contact.normal_max - pressing),
        span=float(contact.normal_max - contact.normal_min),
    )


def _spin_share(contact: ContactTrack, pressing: Array) -> Array:
    """(N,) |m| / (e f_n) of a soft fingertip; 0 without force, which has no margin anyway."""
    assert contact.moment is not None
    largest = contact.torsion * pressing
    loaded = largest > 0.0
    return np.where(loaded, np.abs(contact.moment) / np.where(loaded, largest, 1.0), 0.0)
