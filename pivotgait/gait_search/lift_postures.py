"""Postures of lifts by themselves: most lifts that the hand cannot do fail on the table already."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace

import numpy as np

from pivotgait.frozen import Array
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.hand_fit import HandFit
from pivotgait.gait_search.move_keys import keys_of_move
from pivotgait.gait_search.notes import PATIENCE, Branches, notes_of
from pivotgait.gait_search.states import Move
from pivotgait.models import Scene
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import Postures, Refused

EAGERNESS = 4.0
"""A lift that the hand can do is followed up before others that cost so much less are tried."""


class LiftPostures:
    """Tests of lifts, which learn from those that failed.

    Args:
        scene: of the search.
        fit: of the hand.
        guidance: postures at the goal, from which lifts are tried.
    """

    def __init__(self, scene: Scene, fit: HandFit, guidance: Guidance) -> None:
        self._scene, self._fit, self._guidance = scene, fit, guidance
        self._experience: dict[frozenset[str], Experience] = defaultdict(Experience)
        self._tried = 0

    def expect(self, branch: Branches) -> bool:
        """A lift by fingers whose lifts have failed so far waits longer than others."""
        if (move := branch.move) is not None and move.kind == "lift":
            branch.delay += PATIENCE * self._experience[_fingers(move)].failing
        return True

    def alone(self, branch: Branches) -> bool:
        """Look for postures of a lift without anything to come; lacking them it waits."""
        if branch.parent is None or (move := branch.move) is None or move.kind != "lift":
            return True
        found = self._lifting(tuple(keys_of_move(self._scene, branch.parent.state, move)))
        self._experience[_fingers(move)].add(found is not None)
        if found is None:
            branch.delay += PATIENCE
        else:
            branch.delay -= EAGERNESS
            branch.notes = replace(notes_of(branch), alone=found)
        return True

    def _lifting(self, keys: tuple[KeyPose, ...]) -> Array | None:
        """(3, nv) from the goal's postures and home, the first moment first; else at random."""
        self._tried += 1
        if not len(self._guidance.q):
            tries = self._fit.anywhere(keys, self._tried)
            return next((each.q for each in tries if isinstance(each, Postures)), None)
        rounds = self._fit.rounds[2]
        for start in (*self._guidance.q, self._fit.robot.home):
            lying = self._fit.chain(keys[:1]).settle(start[None], rounds)
            if isinstance(lying, Refused):
                continue
            lifted = self._fit.chain(keys).settle(np.repeat(lying.q, len(keys), axis=0), rounds)
            if not isinstance(lifted, Refused):
                return lifted.q
        return None


@dataclass
class Experience:
    """With lifts by the same fingers.

    Attributes:
        tried: so many.
        passed: of them had postures.
    """

    tried: int = 0
    passed: int = 0

    @property
    def failing(self) -> float:
        """Share of failures to expect of the next one; 0 before the first."""
        return (self.tried - self.passed) / (self.tried + 1)

    def add(self, passed: bool) -> None:
        """Count one more."""
        self.tried, self.passed = self.tried + 1, self.passed + passed


def _fingers(move: Move) -> frozenset[str]:
    return frozenset(each.finger for each in move.contacts)
