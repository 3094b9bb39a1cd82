"""The rest of a sequence, made of nothing but what the goal names: what is still to come.

From a grasp on, the goal's fingers come and the others leave, in the cheapest order whose forces
hold. No contact is left to be chosen, so the whole rest is known before the hand is asked, and its
postures can be fitted to all of it.
"""

from __future__ import annotations

from dataclasses import replace

from pivotgait.gait_search.best_first import BestFirst, Graph
from pivotgait.gait_search.cost import Cost
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.moves import Moves
from pivotgait.gait_search.notes import Branches, notes_of
from pivotgait.gait_search.order import Order
from pivotgait.gait_search.states import GraspState, Move, StateKey

Rest = tuple[Move, ...]
DETOUR = 4.0
"""What a branch waits longer that has no known rest, or leaves the one that was known: contacts
must come in between that the goal does not name."""
KNOWN = 1.3
"""Factor of the cost of a known rest; the rest of the inflation is for what is only estimated."""
LOOKED_AT = 200
"""Most steps of the search for a rest: there are few orders of few fingers."""


class Rollout:
    """Cheapest rests from grasps to the goal.

    Args:
        moves: of the search.
        goal: that names its contacts.
        order: in which fingers may come.
        inflation: of the search's estimate, and so of what is missing in it.

    Attributes:
        scene: of the moves.
    """

    def __init__(self, moves: Moves, goal: Goal, order: Order, inflation: float) -> None:
        self._inflation = inflation
        self.scene = moves.scene
        self._moves = moves.narrowed(goal.contacts, Deaths())
        self._graph = Graph[GraspState, Move](
            key=lambda state: state.key,
            moves=self._moves.of,
            estimate=lambda state: order.rest(state.held, hanging=state.hanging),
            reached=lambda state: goal.reached(state.held) and state.hanging == goal.lifted_off,
            checks=[self._moves.settle_removal],
        )
        self._known: dict[StateKey, Rest | None] = {}

    def prefer_known(self, branch: Branches) -> bool:
        """A branch that leaves the known rest of the one before waits longer than what follows."""
        if branch.parent is None or branch.move is None:
            return True
        known = notes_of(branch.parent).rest
        if known and known[0].name != branch.move.name:
            branch.delay += DETOUR
        return True

    def check(self, branch: Branches) -> bool:
        """Find the rest of a branch: one that is known counts as it is, without inflation."""
        if branch.parent is None or branch.move is None:
            return True
        known = notes_of(branch.parent).rest
        follows = bool(known) and known[0].name == branch.move.name
        # what is left of a rest stays at the attitudes of its coarse scan: near enough
        rest = known[1:] if follows else self(branch.state)
        branch.notes = replace(notes_of(branch), rest=rest or ())
        least = self._graph.estimate(branch.state)
        if rest is None:
            branch.delay += self._inflation * DETOUR
        else:
            cost = sum((move.cost for move in rest), Cost()).total(self._moves.weights)
            branch.delay += KNOWN * cost - self._inflation * least
        return True

    def __call__(self, state: GraspState) -> Rest | None:
        """The moves of the rest; None if forces or places forbid every order."""
        if state.key not in self._known:
            self._known[state.key] = self._found(state)
        return self._known[state.key]

    def _found(self, state: GraspState) -> Rest | None:
        search = BestFirst(self._graph, state)
        for _, branch in zip(range(LOOKED_AT), search.steps(), strict=False):
            if branch is not None:
                return tuple(each.move for each in branch.path() if each.move is not None)
        return None
