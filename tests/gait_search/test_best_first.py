"""Best-first search on small random graphs against brute force."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pivotgait.gait_search.best_first import BestFirst, Branch, Graph

NODES = 8


class Roads:
    """A random directed graph with a start 0 and a goal, and the true costs to the goal."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.goal = NODES - 1
        there = rng.uniform(size=(NODES, NODES)) < 0.45
        np.fill_diagonal(there, False)
        self.cost = np.where(there, rng.uniform(0.1, 1.0, (NODES, NODES)), np.inf)
        # what a closer look finds: some roads are dearer than they seem, some are closed
        self.toll = np.where(rng.uniform(size=(NODES, NODES)) < 0.3, 0.5, 0.0)
        self.closed = rng.uniform(size=(NODES, NODES)) < 0.1

    def true_cost(self) -> np.ndarray:
        return np.where(self.closed, np.inf, self.cost + self.toll)

    def graph(self, estimate: Any = None) -> Graph[int, int]:
        def moves(branch: Branch[int, int]) -> Any:
            at = branch.state
            return [(k, k, self.cost[at, k]) for k in range(NODES) if np.isfinite(self.cost[at, k])]

        def pay(branch: Branch[int, int]) -> bool:
            assert branch.parent is not None
            branch.cost += self.toll[branch.parent.state, branch.state]
            return True

        def is_open(branch: Branch[int, int]) -> bool:
            assert branch.parent is not None
            return not self.closed[branch.parent.state, branch.state]

        return Graph(
            key=lambda state: state,
            moves=moves,
            estimate=estimate or (lambda state: 0.0),
            reached=lambda state: state == self.goal,
            checks=(pay, is_open),
        )

    def all_paths(self) -> list[float]:
        """Costs of all simple paths from the start to the goal, in order."""
        cost, inner = self.true_cost(), range(1, NODES - 1)
        found = []
        for count in range(NODES - 1):
            for middle in itertools.permutations(inner, count):
                way = (0, *middle, self.goal)
                total = sum(cost[a, b] for a, b in itertools.pairwise(way))
                if np.isfinite(total):
                    found.append(float(total))
        return sorted(found)

    def rest(self) -> np.ndarray:
        """True least cost from each node to the goal."""
        cost, rest = self.true_cost(), np.full(NODES, np.inf)
        rest[self.goal] = 0.0
        for _ in range(NODES):
            rest = np.minimum(rest, (cost + rest).min(axis=1))
        return rest


@pytest.mark.parametrize("seed", range(12))
def test_the_first_path_is_a_cheapest_one(seed: int) -> None:
    roads = Roads(seed)
    best, rest = roads.all_paths(), roads.rest()
    finite = np.where(np.isfinite(rest), rest, 1e3)
    estimates = (lambda s: 0.0, lambda s: 0.5 * finite[s], lambda s: finite[s])
    for estimate in estimates:
        first = next(BestFirst(roads.graph(estimate), 0).paths(), None)
        if not best:
            assert first is None
            continue
        assert first is not None
        assert first.cost == pytest.approx(best[0])
        along = [0, *(each.state for each in first.path())]
        true = roads.true_cost()
        assert first.cost == pytest.approx(sum(true[a, b] for a, b in itertools.pairwise(along)))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("inflation", [1.5, 3.0])
def test_inflation_bounds_what_is_lost(seed: int, inflation: float) -> None:
    roads = Roads(seed)
    best, rest = roads.all_paths(), roads.rest()
    finite = np.where(np.isfinite(rest), rest, 1e3)
    search = BestFirst(roads.graph(lambda s: finite[s]), 0, inflation=inflation, visits=NODES)
    first = next(search.paths(), None)
    if best:
        assert first is not None
        assert first.cost <= inflation * best[0] + 1e-12


@pytest.mark.parametrize("seed", range(12))
def test_with_visits_enough_every_path_comes_in_the_order_of_cost(seed: int) -> None:
    roads = Roads(seed)
    best = roads.all_paths()
    search = BestFirst(roads.graph(), 0, visits=10_000)
    costs = []
    for branch in search.paths():
        along = [0, *(each.state for each in branch.path())]
        if len(set(along)) == len(along):
            costs.append(branch.cost)
        if len(costs) == min(len(best), 5):
            break
    assert costs == pytest.approx(best[: len(costs)])


def test_what_grows_from_a_buried_branch_is_never_yielded() -> None:
    roads = Roads(3)
    search = BestFirst(roads.graph(), 0, visits=50)
    first = next(search.paths())
    buried = first.path()[0]
    buried.dead = True
    for branch, _ in zip(search.paths(), range(20), strict=False):
        assert buried not in branch.path()


@pytest.mark.parametrize("seed", range(6))
def test_delays_change_the_order_of_paths_but_not_their_costs(seed: int) -> None:
    roads, plain = Roads(seed), Roads(seed).graph()
    delays = np.random.default_rng(seed).uniform(0.0, 2.0, NODES)

    def wait(branch: Branch[int, int]) -> bool:
        branch.delay += delays[branch.state]
        return True

    waiting = replace(plain, checks=(*plain.checks, wait))
    for branch, _ in zip(BestFirst(waiting, 0, visits=50).paths(), range(5), strict=False):
        along = [0, *(each.state for each in branch.path())]
        true = roads.true_cost()
        assert branch.cost == pytest.approx(sum(true[a, b] for a, b in itertools.pairwise(along)))


def test_a_state_from_which_no_way_leads_on_is_never_looked_at() -> None:
    roads, closed = Roads(3), 4
    graph = roads.graph(lambda state: np.inf if state == closed else 0.0)
    for branch, _ in zip(BestFirst(graph, 0, visits=50).paths(), range(20), strict=False):
        assert closed not in [each.state for each in branch.path()]


def test_a_search_that_cannot_end_well_ends() -> None:
    roads = Roads(0)
    roads.closed[:, roads.goal] = True
    search = BestFirst(roads.graph(), 0)
    assert list(search.paths()) == []
    assert search.waiting == 0
