"""The order of fingers: exact on its few grasps, and never dearer than what moves really cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, product

import numpy as np
import pytest

from pivotgait.gait_search import Candidate, handle_candidates
from pivotgait.gait_search.order import Order, Prices
from pivotgait.models import Scene, load_scene

FINGERS = ("thumb", "index", "middle")
PRICES = Prices(lift=5.0, addition=2.0, removal=3.0, transfer=7.0)
SAMPLES = 12


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(scope="module")
def places(scene: Scene) -> dict[str, list[Candidate]]:
    found = handle_candidates(scene).values()
    return {name: [each for each in found if each.finger == name][:2] for name in FINGERS}


@pytest.fixture(scope="module")
def goal(places: dict[str, list[Candidate]]) -> dict[str, Candidate]:
    return {each[0].name: each[0] for each in places.values()}


def fingers(grasp: Sequence[Candidate]) -> frozenset[str]:
    return frozenset(each.finger for each in grasp)


def order(
    goal: Mapping[str, Candidate],
    lifts: Sequence[Sequence[Candidate]],
    holding: frozenset[frozenset[str]],
    *,
    carried: bool = False,
) -> Order:
    return Order(FINGERS, goal, lifts, lambda g: fingers(g) in holding, PRICES, carried=carried)


def subsets(*, but: Sequence[frozenset[str]] = ()) -> frozenset[frozenset[str]]:
    """Sets of fingers that hold the tool at the goal's contacts."""
    everything = [frozenset(each) for n in (2, 3) for each in combinations(FINGERS, n)]
    return frozenset(each for each in everything if each not in but)


def test_from_the_goal_nothing_is_left(goal: dict[str, Candidate]) -> None:
    held = {each.finger: each for each in goal.values()}
    assert order(goal, [], subsets()).rest(held) == 0.0
    assert order(goal, [], subsets(), carried=True).rest(held) == PRICES.transfer
    assert order(goal, [], subsets(), carried=True).rest(held, hanging=True) == 0.0


@pytest.mark.parametrize("elsewhere", [0, 1, 2])
def test_each_finger_elsewhere_costs_a_removal_and_an_addition(
    goal: dict[str, Candidate], places: dict[str, list[Candidate]], elsewhere: int
) -> None:
    """The third finger comes; the lifting ones that are not at the goal go and come."""
    lift = [places["thumb"][int(elsewhere > 0)], places["index"][int(elsewhere > 1)]]
    found = order(goal, [lift], subsets())
    rest = PRICES.addition + elsewhere * (PRICES.removal + PRICES.addition)
    assert found.rest({each.finger: each for each in lift}) == pytest.approx(rest)
    assert found.rest({}) == pytest.approx(PRICES.lift + rest)


@pytest.mark.parametrize("seed", range(SAMPLES))
def test_a_move_lowers_the_rest_by_no_more_than_it_costs(
    goal: dict[str, Candidate], places: dict[str, list[Candidate]], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    holding = frozenset(each for each in subsets() if rng.uniform() < 0.6 or len(each) == 3)
    found = order(goal, [], holding)
    choices = [[None, *places[name]] for name in FINGERS]
    grasps = [{c.finger: c for c in each if c is not None} for each in product(*choices)]
    for grasp in (each for each in grasps if len(each) == 2):
        for name in set(FINGERS) - set(grasp):
            for place in places[name]:
                more = {**grasp, name: place}
                alone = set(goal) >= {each.name for each in grasp.values()}
                if alone and frozenset(grasp) not in holding:
                    assert found.rest(grasp) == np.inf
                    continue
                assert found.rest(grasp) <= PRICES.addition + found.rest(more) + 1e-12
                assert found.rest(more) <= PRICES.removal + found.rest(grasp) + 1e-12


def test_knowing_less_of_forces_never_makes_the_rest_dearer(
    goal: dict[str, Candidate], places: dict[str, list[Candidate]]
) -> None:
    lift = [places["thumb"][1], places["index"][1]]
    held = {each.finger: each for each in lift}
    free = order(goal, [lift], subsets())
    for bad in combinations(FINGERS, 2):
        tight = order(goal, [lift], subsets(but=[frozenset(bad)]))
        assert tight.rest(held) >= free.rest(held)


def test_without_a_pair_that_holds_no_order_leads_to_the_goal(
    goal: dict[str, Candidate], places: dict[str, list[Candidate]]
) -> None:
    """The last finger comes to two that hold the tool at the goal's contacts."""
    lift = [places["thumb"][1], places["index"][1]]
    pairs = [frozenset(each) for each in combinations(FINGERS, 2)]
    assert order(goal, [lift], subsets(but=pairs)).rest({}) == np.inf
    for pair in pairs:
        others = [each for each in pairs if each != pair]
        assert order(goal, [lift], subsets(but=others)).rest({}) < np.inf


def test_a_goal_that_holds_nowhere_is_not_holdable(goal: dict[str, Candidate]) -> None:
    found = order(goal, [], subsets(but=[frozenset(FINGERS)]))
    assert not found.holdable
    assert found.rest({each.finger: each for each in goal.values()}) == np.inf
    assert order(goal, [], subsets()).holdable
