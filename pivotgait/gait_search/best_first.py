"""Best-first search (A*) that looks at a branch more closely only when it comes to the front.

A branch waits under its cost so far plus an estimate of the rest. When it comes first it is
checked, one check at a time from the cheapest to the dearest; a check may end it or raise its
cost, which sends it back among the waiting ones. With an estimate that never exceeds the true
rest, checks that never lower a cost, inflation 1 and one visit, the first path yielded is a
cheapest one.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from math import inf
from typing import Any, Generic, TypeVar

S = TypeVar("S")
M = TypeVar("M")


@dataclass(eq=False)
class Branch(Generic[S, M]):
    """A state and how the search came there.

    Attributes:
        state: reached.
        cost: from the start, as far as known.
        parent: the branch it grew from, None for the start.
        move: from the parent.
        checked: number of checks passed.
        delay: added to its rank: it waits so much longer than its cost says.
        dead: whether it has been given up, and all that grows from it.
        notes: what checks found out, for those that come later.
    """

    state: S
    cost: float
    parent: Branch[S, M] | None = None
    move: M | None = None
    checked: int = 0
    delay: float = 0.0
    dead: bool = False
    notes: Any = None

    def path(self) -> list[Branch[S, M]]:
        """From the start's first child to this branch."""
        if self.parent is None:
            return []
        return [*self.parent.path(), self]

    def is_dead(self) -> bool:
        """Whether it or one that it grew from has been given up."""
        return self.dead or (self.parent is not None and self.parent.is_dead())


Check = Callable[[Branch[S, M]], bool]
"""Whether a branch may live; may raise its cost or delay, and change its state, move and notes."""


@dataclass(frozen=True)
class Graph(Generic[S, M]):
    """What is searched.

    Attributes:
        key: states with the same one are the same.
        moves: from a state: moves, the states they lead to, and their least costs.
        estimate: of the rest of the cost from a state; infinite where no way leads to a goal.
        reached: whether a state is a goal; goals are not left again.
        checks: of a branch, from the cheapest to the dearest.
    """

    key: Callable[[S], Hashable]
    moves: Callable[[Branch[S, M]], Iterable[tuple[M, S, float]]]
    estimate: Callable[[S], float]
    reached: Callable[[S], bool]
    checks: Sequence[Check[S, M]] = ()


class BestFirst(Generic[S, M]):
    """The search.

    Args:
        graph: what is searched.
        start: a state.
        inflation: factor of the estimate; above 1 the search is greedier and its first path may
            be dearer than the cheapest by up to this factor.
        visits: times that a state may be left on different paths: more than one where checks
            depend on the path.

    Attributes:
        expanded: number of branches whose moves were looked at.
        waiting: number of branches in the queue.
    """

    def __init__(
        self, graph: Graph[S, M], start: S, *, inflation: float = 1.0, visits: int = 1
    ) -> None:
        self._graph, self._inflation, self._visits = graph, inflation, visits
        self._order = count()
        self._seen: Counter[Hashable] = Counter()
        self._queue: list[tuple[float, int, Branch[S, M]]] = []
        self.expanded = 0
        self._push(Branch(start, 0.0, checked=len(graph.checks)))

    @property
    def waiting(self) -> int:
        """Number of branches in the queue."""
        return len(self._queue)

    def paths(self) -> Iterator[Branch[S, M]]:
        """Branches that end in goals, cheapest first; the caller may give some up meanwhile.

        Yields None-free branches; the search goes on where it stopped.
        """
        for branch in self.steps():
            if branch is not None:
                yield branch

    def steps(self) -> Iterator[Branch[S, M] | None]:
        """As :meth:`paths`, and None after each branch looked at, so that a caller may stop."""
        graph = self._graph
        while self._queue:
            _, _, branch = heapq.heappop(self._queue)
            if branch.is_dead() or self._used_up(branch):
                continue
            if branch.checked < len(graph.checks):
                self._check(branch)
                yield None
                continue
            self._seen[graph.key(branch.state)] += 1
            if graph.reached(branch.state):
                yield branch
                continue
            self.expanded += 1
            for move, state, cost in graph.moves(branch):
                self._push(Branch(state, branch.cost + cost, branch, move))
            yield None

    def _check(self, branch: Branch[S, M]) -> None:
        check = self._graph.checks[branch.checked]
        if not check(branch):
            branch.dead = True
            return
        branch.checked += 1
        self._push(branch)

    def _used_up(self, branch: Branch[S, M]) -> bool:
        return self._seen[self._graph.key(branch.state)] >= self._visits

    def _push(self, branch: Branch[S, M]) -> None:
        if self._used_up(branch):
            return
        rank = branch.cost + self._inflation * self._graph.estimate(branch.state) + branch.delay
        if rank == inf:
            return
        heapq.heappush(self._queue, (rank, next(self._order), branch))
