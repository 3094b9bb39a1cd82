"""How long phases take, and how gaits are timed: as the scene's own gaits are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from pivotgait.models import (
    AdditionPhase,
    LiftPhase,
    LiftTarget,
    PhaseConfig,
    RelocationPhase,
    RemovalPhase,
    Scene,
    TransferPhase,
)

P = TypeVar("P", LiftPhase, AdditionPhase, RemovalPhase, RelocationPhase, TransferPhase)
HOVER_M = 0.05
"""Way of a fingertip that comes from the air [m]."""
STAND_OFF_M = 0.01
"""Distance that a finger keeps which does not carry the tool off the table [m]."""
RETREAT_M = 0.016
"""Away from one contact and towards the next [m]."""
RELOCATION_S, TIP_SPEED_M_S = 0.5, 0.2
"""A relocation takes so long and the way at this speed besides."""


@dataclass(frozen=True)
class PhaseStyle:
    """One phase of each kind, to be written like.

    Attributes:
        lift: its target is the one that lifts of the search end in.
        addition: its timing counts.
        removal: its timing and weights count.
        relocation: its sampling counts.
        transfer: its timing and height count.
    """

    lift: LiftPhase
    addition: AdditionPhase
    removal: RemovalPhase
    relocation: RelocationPhase
    transfer: TransferPhase

    @classmethod
    def of(cls, scene: Scene) -> PhaseStyle:
        """The first phase of each kind in the scene's gaits, or one that is usual."""
        phases = [phase for gait in scene.gaits.values() for phase in gait]
        names = tuple(scene.contacts)
        target = LiftTarget(pitch_deg=25.0, roll_deg=-scene.config.rest.roll_deg)
        lift = LiftPhase(kind="lift", contacts=names[:2], duration_s=1.5, steps=75, to=target)
        addition = AdditionPhase(kind="addition", contact=names[0], duration_s=0.8, steps=40)
        removal = RemovalPhase(kind="removal", contact=names[0], duration_s=1.6, steps=64)
        relocation = RelocationPhase(kind="relocation", contact=names[0])
        transfer = TransferPhase(kind="transfer", duration_s=2.0, steps=100)
        return cls(
            _first(phases, lift),
            _first(phases, addition),
            _first(phases, removal),
            _first(phases, relocation),
            _first(phases, transfer),
        )

    def relocation_s(self, way_m: float) -> float:
        """Estimate of a relocation's duration [s]; the joints' limits decide it later."""
        return RELOCATION_S + way_m / TIP_SPEED_M_S


def _first(phases: list[PhaseConfig], usual: P) -> P:
    return next((phase for phase in phases if isinstance(phase, type(usual))), usual)
