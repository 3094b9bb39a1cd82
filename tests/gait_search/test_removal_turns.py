"""Turns after removals: exact ones are the smallest, coarse ones hold and are remembered."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.feasibility.turns import smallest_tilt
from pivotgait.gait_search.candidates import own_candidates
from pivotgait.gait_search.removal_turns import RemovalTurns
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.models import LiftPhase, load_scene

SCENE = load_scene("knife")
OWN = dict(own_candidates(SCENE))
STAYING = [OWN["thumb_spine"], OWN["middle_flat"]]
LIFTED = SCENE.lift_rotation(next(p for p in SCENE.gaits["default"] if isinstance(p, LiftPhase)).to)


def depth(rotation: Rotation) -> float:
    return float(grasp_depths(SCENE, [[each.contact for each in STAYING]], rotation)[0])


def test_an_exact_turn_is_the_smallest_tilt() -> None:
    turn = RemovalTurns(SCENE)(STAYING, LIFTED)
    wanted = smallest_tilt(SCENE, [each.contact for each in STAYING], LIFTED)
    assert turn.angle == wanted.angle > 0.0
    assert turn.rotation.as_quat() == pytest.approx(wanted.rotation.as_quat(), abs=0.0)


def test_a_coarse_turn_ends_where_the_fingers_hold_the_tool() -> None:
    turns = RemovalTurns(SCENE, LIFTED)
    assert depth(LIFTED) < 0.0
    turn = turns(STAYING, LIFTED)
    assert turn.feasible
    assert depth(turn.rotation) >= 0.0
    exact = smallest_tilt(SCENE, [each.contact for each in STAYING], LIFTED)
    assert turn.angle >= exact.angle - 1e-9


def test_what_holds_as_it_is_is_not_turned() -> None:
    turns = RemovalTurns(SCENE, LIFTED)
    held = turns(STAYING, LIFTED).rotation
    turn = turns(STAYING, held)
    assert (turn.feasible, turn.angle) == (True, 0.0)
    assert turn.rotation is held


def test_from_elsewhere_the_way_is_to_the_same_attitude() -> None:
    turns = RemovalTurns(SCENE, LIFTED)
    first = turns(STAYING, LIFTED)
    elsewhere = Rotation.from_rotvec([0.0, 0.05, 0.0]) * LIFTED
    assert depth(elsewhere) < 0.0
    again = turns(STAYING, elsewhere)
    np.testing.assert_array_equal(again.rotation.as_quat(), first.rotation.as_quat())
    assert again.angle == pytest.approx((again.rotation * elsewhere.inv()).magnitude())
