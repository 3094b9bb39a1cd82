"""Where a search stands: who holds the tool where, in which attitude; and the moves between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.cost import Cost
from pivotgait.models import LiftTarget

MoveKind = Literal["lift", "addition", "removal", "transfer"]
ATTITUDE_DIGITS = 2
"""Attitudes that agree in so many digits of their rotation vector [rad] are one state."""
StateKey = tuple[tuple[str, ...], tuple[str, ...], tuple[float, ...], bool]


@dataclass(frozen=True, eq=False)
class GraspState:
    """The tool at rest.

    Attributes:
        rotation: of the tool, world <- tool.
        held: finger -> where it holds; none while the tool lies on the table.
        left: finger that holds nothing -> where it last did.
        depth_N: how far inside the limits of forces the grasp is, see
            :class:`pivotgait.feasibility.StaticVerdicts`.
        hanging: whether the tool is off the table, carried by the fingers alone.
    """

    rotation: Rotation
    held: Mapping[str, Candidate] = field(default_factory=lambda: MappingProxyType({}))
    left: Mapping[str, Candidate] = field(default_factory=lambda: MappingProxyType({}))
    depth_N: float = np.inf
    hanging: bool = False

    @property
    def key(self) -> StateKey:
        """What makes two states the same."""
        turn = np.round(self.rotation.as_rotvec(), ATTITUDE_DIGITS) + 0.0
        return (
            tuple(sorted(each.name for each in self.held.values())),
            tuple(sorted(each.name for each in self.left.values())),
            tuple(turn.tolist()),
            self.hanging,
        )

    def with_finger(self, candidate: Candidate, depth_N: float) -> GraspState:
        """The state after an addition."""
        held = {**self.held, candidate.finger: candidate}
        left = {name: each for name, each in self.left.items() if name != candidate.finger}
        return GraspState(self.rotation, MappingProxyType(held), MappingProxyType(left), depth_N)

    def without_finger(self, finger: str, rotation: Rotation, depth_N: float) -> GraspState:
        """The state after a removal that ends in another attitude."""
        held = {name: each for name, each in self.held.items() if name != finger}
        left = {**self.left, finger: self.held[finger]}
        return GraspState(rotation, MappingProxyType(held), MappingProxyType(left), depth_N)


@dataclass(frozen=True, eq=False)
class Move:
    """An edge of the search: one phase, relocations before it included.

    Attributes:
        kind: of the phase.
        contacts: that come, or the one that leaves, or all that carry the tool off the table.
        after: the state it ends in.
        cost: an estimate that may grow when the move is looked at more closely.
        target: attitude that a lift ends in.
    """

    kind: MoveKind
    contacts: tuple[Candidate, ...]
    after: GraspState
    cost: Cost
    target: LiftTarget | None = None

    @property
    def name(self) -> str:
        """Kind and contacts, for people."""
        sign = {"addition": "+", "removal": "-"}.get(self.kind, f"{self.kind} ")
        return sign + ", ".join(each.name for each in self.contacts)
