"""Postures of lifts by themselves: they hold where they say; failures teach patience."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.gait_search import CostWeights, Deaths, handle_candidates, read_goal
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.hand_fit import HandFit
from pivotgait.gait_search.lift_postures import EAGERNESS, LiftPostures
from pivotgait.gait_search.moves import Moves
from pivotgait.gait_search.notes import PATIENCE, notes_of
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.models import Scene, load_scene
from pivotgait.planning.posture_search import PostureOptions

Branches = Branch[GraspState, Move]
HOLDS = {"thumb_spine", "index_edge"}
PINCH = frozenset({"index", "middle"})
"""Beside one another they cannot pinch the knife's handle."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(scope="module")
def moves(scene: Scene) -> Moves:
    return Moves(scene, handle_candidates(scene), CostWeights(), Deaths())


def postures_with(scene: Scene, moves: Moves, starts: int) -> LiftPostures:
    assert scene.robot is not None
    goal = read_goal("power-grasp", scene)  # names no contacts: no guidance, quick to make
    attitude = scene.lift_rotation(moves.targets()[0])
    guidance = Guidance(scene, scene.robot, goal, attitude, np.random.default_rng(0))
    options = PostureOptions(starts=starts, time_limit_s=np.inf)
    return LiftPostures(scene, HandFit(scene, scene.robot, options, 0), guidance)


@pytest.fixture
def postures(scene: Scene, moves: Moves) -> LiftPostures:
    return postures_with(scene, moves, starts=1)


def lifts(moves: Moves, fingers: frozenset[str]) -> list[Branches]:
    start = Branch(moves.start(), 0.0)
    return [
        Branch(move.after, 1.0, start, move)
        for move in moves.lifts
        if {each.finger for each in move.contacts} == fingers
    ]


def test_a_lift_s_own_postures_are_on_its_contacts(scene: Scene, moves: Moves) -> None:
    robot, postures = scene.robot, postures_with(scene, moves, starts=30)
    assert robot is not None
    thumb = lifts(moves, frozenset({"thumb", "index"}))
    (branch,) = (b for b in thumb if b.move and {c.name for c in b.move.contacts} == HOLDS)
    assert postures.alone(branch)
    found, data = notes_of(branch).alone, robot.model.createData()
    assert found is not None
    assert found.shape == (3, robot.nv)
    assert branch.delay == -EAGERNESS
    for q, rotation in ((found[0], scene.rest_rotation), (found[-1], branch.state.rotation)):
        pin.framesForwardKinematics(robot.model, data, np.array(q))
        for each in branch.state.held.values():
            finger = robot.fingers[each.finger]
            tip = each.contact.point - finger.tip_radius * each.contact.normal
            place = scene.centre_of_mass(rotation) + rotation.as_matrix() @ tip
            np.testing.assert_allclose(data.oMf[finger.tip_frame_id].translation, place, atol=1e-9)


def test_lifts_by_fingers_that_failed_wait_and_others_do_not(
    moves: Moves, postures: LiftPostures
) -> None:
    pinches, others = lifts(moves, PINCH), lifts(moves, frozenset({"thumb", "index"}))
    first, second, third = pinches[:3]
    assert postures.expect(first)
    assert first.delay == 0.0
    assert postures.alone(first)
    assert notes_of(first).alone is None
    assert first.delay == PATIENCE
    postures.expect(second)
    assert second.delay == pytest.approx(PATIENCE / 2.0)
    postures.alone(second)
    postures.expect(third)
    assert third.delay == pytest.approx(PATIENCE * 2.0 / 3.0)
    postures.expect(others[0])
    assert others[0].delay == 0.0


def test_what_is_no_lift_is_left_alone(moves: Moves, postures: LiftPostures) -> None:
    lift = lifts(moves, frozenset({"thumb", "index"}))[0]
    move, state, _ = next(each for each in moves.of(lift) if each[0].kind == "addition")
    branch = Branch(state, 2.0, lift, move)
    assert postures.expect(branch)
    assert postures.alone(branch)
    assert (branch.delay, notes_of(branch).alone) == (0.0, None)
