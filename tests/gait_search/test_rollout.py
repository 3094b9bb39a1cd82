"""Rests of sequences: they lead to the goal, hold at every step and use its contacts alone."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.feasibility.turns import held_at
from pivotgait.gait_search import CostWeights, Deaths, Goal, handle_candidates, read_goal
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.cost import Cost
from pivotgait.gait_search.moves import Moves
from pivotgait.gait_search.notes import notes_of
from pivotgait.gait_search.order import Order
from pivotgait.gait_search.rollout import DETOUR, Rollout
from pivotgait.gait_search.search import without_robot
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.models import load_scene

INFLATION = 2.0


@pytest.fixture(scope="module")
def moves() -> Moves:
    scene = without_robot(load_scene("knife"))
    return Moves(scene, handle_candidates(scene), CostWeights(), Deaths())


@pytest.fixture(scope="module")
def goal(moves: Moves) -> Goal:
    return read_goal("thumb_spine, middle_flat, index_edge_near", moves.scene)


@pytest.fixture(scope="module")
def order(moves: Moves, goal: Goal) -> Order:
    lifts = [move.contacts for move in moves.lifts]
    fingers = ("thumb", "index", "middle")
    return Order(fingers, goal.contacts, lifts, lambda grasp: True, moves.prices)


@pytest.fixture(scope="module")
def rollout(moves: Moves, goal: Goal, order: Order) -> Rollout:
    return Rollout(moves, goal, order, INFLATION)


@pytest.fixture(scope="module")
def lifts(moves: Moves) -> list[Move]:
    return list(moves.lifts[::9])


def test_rests_end_in_the_goal_and_hold_at_every_step(
    rollout: Rollout, lifts: list[Move], goal: Goal
) -> None:
    known = [rest for rest in (rollout(lift.after) for lift in lifts) if rest is not None]
    assert known
    for rest in known:
        assert goal.reached(rest[-1].after.held)
        for move in rest:
            contacts = [each.contact for each in move.after.held.values()]
            grasps = held_at(rollout.scene, contacts, move.after.rotation)
            assert static_verdicts(grasps, exact=True).feasible.all()


def test_nothing_comes_but_what_the_goal_names(
    rollout: Rollout, lifts: list[Move], goal: Goal
) -> None:
    for lift in lifts:
        for move in rollout(lift.after) or ():
            if move.kind == "addition":
                assert move.contacts[0].name in goal.contacts


def test_a_rest_costs_no_less_than_the_order_of_fingers_says(
    rollout: Rollout, lifts: list[Move], moves: Moves, order: Order
) -> None:
    for lift in lifts:
        rest = rollout(lift.after)
        if rest is not None:
            cost = sum((move.cost for move in rest), Cost()).total(moves.weights)
            assert cost >= order.rest(lift.after.held) - 1e-9


def test_a_branch_that_follows_a_rest_keeps_what_is_left_of_it(
    rollout: Rollout, lifts: list[Move], moves: Moves
) -> None:
    root: Branch[GraspState, Move] = Branch(moves.start(), 0.0)
    lift = next(each for each in lifts if rollout(each.after))
    first = Branch(lift.after, 1.0, root, lift)
    assert rollout.check(first)
    rest = notes_of(first).rest
    following = Branch(rest[0].after, 2.0, first, rest[0])
    assert rollout.check(following)
    assert notes_of(following).rest == rest[1:]


def test_a_branch_without_a_known_rest_waits(rollout: Rollout, moves: Moves) -> None:
    root: Branch[GraspState, Move] = Branch(moves.start(), 0.0)
    blind = next(each for each in moves.lifts if rollout(each.after) is None)
    branch = Branch(blind.after, 1.0, root, blind)
    assert rollout.check(branch)
    assert notes_of(branch).rest == ()
    assert 0.0 < branch.delay < np.inf


def test_what_leaves_a_known_rest_waits_and_what_follows_it_does_not(
    rollout: Rollout, moves: Moves
) -> None:
    start = Branch(moves.start(), 0.0)
    lift = next(each for each in moves.lifts if rollout(each.after))
    parent = Branch(lift.after, 1.0, start, lift)
    assert rollout.prefer_known(parent)
    assert parent.delay == 0.0  # nothing is known of the start
    assert rollout.check(parent)
    following = notes_of(parent).rest[0]
    for move, state, cost in moves.of(parent):
        branch = Branch(state, 1.0 + cost, parent, move)
        assert rollout.prefer_known(branch)
        assert branch.delay == (0.0 if move.name == following.name else DETOUR)
