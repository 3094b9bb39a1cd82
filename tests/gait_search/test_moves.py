"""Moves: their costs keep the search's estimate below the truth; what dies is counted."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from pivotgait.exceptions import InputError
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.feasibility.turns import held_at, smallest_tilt
from pivotgait.gait_search import Cost, CostWeights, Deaths, handle_candidates, read_goal
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.goals import estimate_moves
from pivotgait.gait_search.moves import LIFTED_BY, MoveOptions, Moves
from pivotgait.gait_search.search import without_robot
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.models import Scene, load_scene

GOALS = ("thumb_spine, middle_flat, index_edge_near", "power-grasp")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(scope="module", params=[True, False], ids=["hand", "tool"])
def moves(request: pytest.FixtureRequest, scene: Scene) -> Moves:
    used = scene if request.param else without_robot(scene)
    return Moves(used, handle_candidates(used), CostWeights(), Deaths())


Branches = Branch[GraspState, Move]


@pytest.fixture(scope="module")
def grown(moves: Moves) -> list[Branches]:
    """Branches of up to three moves, removals settled."""
    level: list[Branches] = [Branch(moves.start(), 0.0)]
    found: list[Branches] = []
    for count in (6, 4, 4):
        longer = []
        for branch in level:
            everything = list(moves.of(branch))
            removals = [each for each in everything if each[0].kind == "removal"]
            step = max(1, len(everything) // count)
            for move, state, cost in [*islice(everything, 0, None, step), *removals]:
                new = Branch(state, branch.cost + cost, branch, move)
                if moves.settle_removal(new):
                    longer.append(new)
        found += longer
        level = longer[:: max(1, len(longer) // 4)]
    return found


@pytest.mark.parametrize("text", GOALS)
def test_the_estimate_falls_by_no_more_than_a_move_costs(
    moves: Moves, grown: list[Branches], scene: Scene, text: str
) -> None:
    goal = read_goal(text, scene)

    def rest(state: GraspState) -> float:
        lifts, missing = estimate_moves(goal, state, LIFTED_BY)
        return moves.least(lifts, missing.additions, missing.removals)

    kinds = set()
    for branch in grown:
        assert branch.parent is not None
        assert branch.move is not None
        kinds.add(branch.move.kind)
        assert (
            rest(branch.parent.state)
            <= branch.cost - branch.parent.cost + rest(branch.state) + 1e-9
        )
    assert kinds == {"lift", "addition", "removal"}


def test_every_state_can_be_held_at_rest(grown: list[Branches], scene: Scene) -> None:
    for branch in grown:
        state = branch.state
        contacts = [each.contact for each in state.held.values()]
        verdict = static_verdicts(held_at(scene, contacts, state.rotation), exact=True)
        assert verdict.feasible.all()
        assert state.depth_N == pytest.approx(float(verdict.depth[0]), abs=1e-6)


def test_a_removal_turns_the_tool_no_more_than_it_must(grown: list[Branches], scene: Scene) -> None:
    removals = [b for b in grown if b.move is not None and b.move.kind == "removal"]
    for branch in removals[:4]:
        assert branch.parent is not None
        before, after = branch.parent.state, branch.state
        staying = [each.contact for each in after.held.values()]
        turn = smallest_tilt(scene, staying, before.rotation)
        angle = (after.rotation * before.rotation.inv()).magnitude()
        assert angle == pytest.approx(turn.angle, abs=1e-9)
        assert set(after.left) >= set(before.held) - set(after.held)


def test_batches_say_what_single_grasps_say(scene: Scene) -> None:
    found = list(handle_candidates(scene).values())
    thumbs = [each.contact for each in found if each.finger == "thumb"][:12]
    indices = [each.contact for each in found if each.finger == "index"][:12]
    grasps = [[a, b] for a in thumbs for b in indices]
    together = grasp_depths(scene, grasps, scene.rest_rotation)
    alone = [grasp_depths(scene, [each], scene.rest_rotation)[0] for each in grasps[::7]]
    assert np.allclose(together[::7], alone, atol=1e-7)
    signs = grasp_depths(scene, grasps, scene.rest_rotation, exact=False)
    assert np.array_equal(signs >= 0.0, together >= 0.0)
    assert grasp_depths(scene, [], scene.rest_rotation).shape == (0,)


def test_dead_moves_are_counted_by_their_reason(moves: Moves) -> None:
    alive = list(moves.of(Branch(moves.start(), 0.0)))
    once = moves.deaths.total
    stages = {stage for stage, _, _ in moves.deaths.rows()}
    assert len(alive) > 100
    assert len(list(moves.of(Branch(moves.start(), 0.0)))) == len(alive)
    assert moves.deaths.total == once  # lifts are judged once
    assert {"over the table", "forces at rest"} <= stages


def test_lifts_to_another_pitch_wait_but_cost_the_same(scene: Scene) -> None:
    pitched = MoveOptions(pitches_deg=(10.0, 40.0))
    deaths, used = Deaths(), without_robot(scene)
    there = Moves(used, handle_candidates(used), CostWeights(), deaths, pitched)
    root, own = Branch(there.start(), 0.0), there.style.lift.to.pitch_deg
    seen = set()
    for move, state, cost in there.of(root):
        branch = Branch(state, cost, root, move)
        assert there.prefer_own_lifts(branch)
        assert branch.cost == cost
        assert move.target is not None
        assert (branch.delay > 0.0) == (move.target.pitch_deg != own)
        seen.add(move.target.pitch_deg)
    assert seen == {own, 10.0, 40.0}


def test_costs_add_up_and_weigh() -> None:
    weights = CostWeights(2.0, 3.0, 0.5, 5.0, 7.0)
    one, other = Cost(0.1, 0.2, 0.3, 0.4), Cost(1.0, 1.0, 1.0, 1.0)
    assert (one + other).total(weights) == pytest.approx(one.total(weights) + other.total(weights))
    assert other.total(weights) == pytest.approx(17.0)
    assert [weights.shortfall(depth) for depth in (-1.0, 0.0, 0.25, 0.5, 9.0)] == [1, 1, 0.5, 0, 0]


@pytest.mark.parametrize("name", ["reorientation", "margin", "margin_wish_N", "path", "time"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_weights_are_finite_and_not_negative(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        CostWeights(**{name: value})
