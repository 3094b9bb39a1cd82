"""In which order fingers may come at all, when a contact counts only as the goal's or another.

A grasp is then a word of three letters' alphabet: each finger is free, at its contact of the goal,
or elsewhere. There are few such grasps, so the cheapest way from each to the goal is known exactly
(a pattern database: Culberson, Schaeffer, Comput. Intell. 14(3), 1998). What is known of forces
cuts ways off: a goal's contacts that hold the tool in no attitude are never left alone with it.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np

from pivotgait.gait_search.candidates import Candidate

Place = Literal["free", "goal", "elsewhere"]
Pattern = tuple[Place, ...]
"""For each finger, where it is."""
FEWEST = 2
"""Fingers that can hold the tool on its pivot."""


@dataclass(frozen=True)
class Prices:
    """Least cost of a move of each kind.

    Attributes:
        lift: of the first grasp.
        addition: of a finger, its relocation included.
        removal: of a finger.
        transfer: off the table.
    """

    lift: float
    addition: float
    removal: float
    transfer: float


class Order:
    """Least cost from grasps to a goal that names its contacts.

    Args:
        fingers: of the hand.
        contacts: of the goal, by name.
        lifts: grasps that lift the tool off the table.
        holds: whether some of the goal's contacts hold the tool by themselves in any attitude.
        prices: of moves.
        carried: whether the tool is taken off the table in the end.

    Attributes:
        holdable: whether the goal's contacts hold the tool in any attitude.
    """

    def __init__(
        self,
        fingers: Sequence[str],
        contacts: Mapping[str, Candidate],
        lifts: Iterable[Sequence[Candidate]],
        holds: Callable[[Sequence[Candidate]], bool],
        prices: Prices,
        *,
        carried: bool = False,
    ) -> None:
        self._fingers, self._contacts, self._prices = tuple(fingers), contacts, prices
        self._last = prices.transfer if carried else 0.0
        at_goal = {each.finger: each for each in contacts.values()}
        self._places: list[tuple[Place, ...]] = [
            ("free", "goal", "elsewhere") if name in at_goal else ("free", "elsewhere")
            for name in self._fingers
        ]
        self._held = {
            pattern for pattern in product(*self._places) if self._may_hold(pattern, at_goal, holds)
        }
        goal: Pattern = tuple("goal" if name in at_goal else "free" for name in self._fingers)
        self.holdable = goal in self._held
        self._rest = self._distances(goal) if self.holdable else {}
        lifted = {self.pattern({each.finger: each for each in grasp}) for grasp in lifts}
        self._start = prices.lift + min((self._from(each) for each in lifted), default=np.inf)

    @property
    def possible(self) -> bool:
        """Whether any order of fingers leads from the table to the goal."""
        return self._start < np.inf

    @property
    def binding(self) -> str:
        """Why none does."""
        return "none ends in the goal" if self.holdable else "the goal holds in no attitude"

    def pattern(self, held: Mapping[str, Candidate]) -> Pattern:
        """Of a grasp: finger -> where it holds."""

        def place(finger: str) -> Place:
            if finger not in held:
                return "free"
            return "goal" if held[finger].name in self._contacts else "elsewhere"

        return tuple(place(name) for name in self._fingers)

    def rest(self, held: Mapping[str, Candidate], *, hanging: bool = False) -> float:
        """Least cost from a grasp to the goal, infinite if no order of fingers leads there.

        Args:
            held: finger -> where it holds; none while the tool lies on the table.
            hanging: whether the tool is off the table already.
        """
        if hanging:
            return 0.0
        return self._last + (self._from(self.pattern(held)) if held else self._start)

    def _from(self, pattern: Pattern) -> float:
        return self._rest.get(pattern, np.inf)

    def _may_hold(
        self,
        pattern: Pattern,
        at_goal: Mapping[str, Candidate],
        holds: Callable[[Sequence[Candidate]], bool],
    ) -> bool:
        holding = [name for name, at in zip(self._fingers, pattern, strict=True) if at != "free"]
        if len(holding) < FEWEST:
            return False
        if "elsewhere" in pattern:
            return True
        return holds([at_goal[name] for name in holding])

    def _distances(self, goal: Pattern) -> dict[Pattern, float]:
        """Least cost to ``goal`` from every grasp that leads there (Dijkstra, backwards)."""
        done: dict[Pattern, float] = {}
        queue = [(0.0, goal)]
        while queue:
            cost, pattern = heapq.heappop(queue)
            if pattern in done:
                continue
            done[pattern] = cost
            for before, price in self._before(pattern):
                if before not in done:
                    heapq.heappush(queue, (cost + price, before))
        return done

    def _before(self, pattern: Pattern) -> Iterator[tuple[Pattern, float]]:
        """Grasps from which one move leads to a grasp, and what it costs at least."""
        for k, places in enumerate(self._places):
            for place in places:
                if (place == "free") == (pattern[k] == "free"):
                    continue
                before = (*pattern[:k], place, *pattern[k + 1 :])
                if before in self._held:
                    came = place == "free"
                    yield before, self._prices.addition if came else self._prices.removal
