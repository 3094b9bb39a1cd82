"""Room beside contacts: where fingers come and go, in the order of time, with postures near."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.gait_search import CostWeights, Deaths, handle_candidates
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.moves import Moves
from pivotgait.gait_search.notes import Branches, Notes, Prefix, notes_of
from pivotgait.gait_search.room import BESIDE_M, with_room
from pivotgait.gait_search.search import without_robot
from pivotgait.gait_search.states import GraspState
from pivotgait.models import load_scene
from pivotgait.planning.key_posture import KeyPose

SCENE = without_robot(load_scene("knife"))
KEYS = {"lift": 3, "addition": 1, "removal": 2}


def pose(state: GraspState, name: str) -> KeyPose:
    contacts = {finger: each.contact for finger, each in state.held.items()}
    place = SCENE.centre_of_mass(state.rotation)
    return KeyPose(name, state.rotation.as_matrix(), place, contacts)


@pytest.fixture(scope="module")
def path() -> list[Branches]:
    """A lift, an addition, the removal of a finger of the lift, its addition elsewhere."""
    moves = Moves(SCENE, handle_candidates(SCENE), CostWeights(), Deaths())
    branch: Branches = Branch(moves.start(), 0.0)
    keys: tuple[KeyPose, ...] = ()
    leaving = ""
    for kind in ("lift", "addition", "removal", "addition"):
        fitting = (each for each in moves.of(branch) if each[0].kind == kind)
        if kind == "removal":
            fitting = (e for e in fitting if e[0].contacts[0].finger == leaving)
        if keys and leaving and kind == "addition" and branch.state.left:
            fitting = (e for e in fitting if e[0].contacts[0].finger == leaving)
        move, state, cost = next(fitting)
        leaving = leaving or move.contacts[0].finger
        branch = Branch(state, branch.cost + cost, branch, move)
        keys = (*keys, *(pose(state, f"{kind} {k}") for k in range(KEYS[kind])))
        branch.notes = Notes(prefix=Prefix(keys, np.zeros((len(keys), 2)), len(keys)))
    return branch.path()


def test_own_key_poses_stay_as_they_are_and_in_order(path: list[Branches]) -> None:
    moments = list(with_room(path))
    prefix = notes_of(path[-1]).prefix
    assert prefix is not None
    own = [each for each in moments if each.own]
    assert [each.like for each in own] == list(range(prefix.done))
    assert [each.key for each in own] == list(prefix.keys)


def test_fingers_have_room_where_they_leave_and_come(path: list[Branches]) -> None:
    beside = [each for each in with_room(path) if not each.own]
    first, again = path[1].move, path[3].move
    assert first is not None
    assert again is not None
    (left,) = path[2].move.contacts if path[2].move else ()
    wanted = [first.contacts[0], left, again.contacts[0]]
    assert [each.key.name for each in beside] == [f"beside {each.name}" for each in wanted]
    for moment, at in zip(beside, wanted, strict=True):
        held = moment.key.contacts[at.finger]
        out = held.point - at.contact.point
        np.testing.assert_allclose(out, -BESIDE_M * at.contact.normal, atol=1e-15)
        assert held.name != at.name  # no contact that lasts


def test_postures_near_are_those_just_before_leaving_and_at_the_arrival(
    path: list[Branches],
) -> None:
    moments = list(with_room(path))
    assert [each.like for each in moments] == [0, 1, 2, 3, 3, 4, 5, 5, 6, 6]
