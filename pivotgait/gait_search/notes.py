"""What the tests of a branch found out, for later tests and for what grows from it."""

from __future__ import annotations

from dataclasses import dataclass

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.planning.key_posture import KeyPose

Branches = Branch[GraspState, Move]
PATIENCE = 5.0
"""Branches that costs say are so much worse are looked at before random starts are made."""


@dataclass(frozen=True, eq=False)
class Prefix(FrozenArrays):
    """A branch's key poses so far and to come, and postures for them.

    Attributes:
        keys: in the order of time.
        q: (K, nv).
        done: number of key poses that belong to the branch; the others are still to come.
    """

    keys: tuple[KeyPose, ...]
    q: Array
    done: int


@dataclass(frozen=True, eq=False)
class Notes:
    """About a branch.

    Attributes:
        rest: moves to come, none if no rest is known.
        alone: (3, nv) postures of a lift by itself; None before there are some.
        prefix: postures; None before there are some.
    """

    rest: tuple[Move, ...] = ()
    alone: Array | None = None
    prefix: Prefix | None = None


def notes_of(branch: Branches) -> Notes:
    """What is known of a branch; nothing about one that no test has looked at."""
    return branch.notes if isinstance(branch.notes, Notes) else Notes()
