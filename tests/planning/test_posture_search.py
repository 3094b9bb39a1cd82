"""Postures that are found keep everything they promise; those not found say what is in the way."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InfeasibleError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.kinematics import TaskJacobian, choose_palm_rows
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import held_on
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_residuals import PostureResiduals
from pivotgait.planning.posture_search import PostureOptions, PostureSearch
from tests.planning.knife_keys import SINGULAR_VALUE_MIN, keys, robot, scene, world

ROLL_RAD = 0.03  # slack of a direction that the chain allows


def search(seed: int, **options: object) -> PostureSearch:
    given = PostureOptions(singular_value_min=SINGULAR_VALUE_MIN, **options)
    return PostureSearch(robot(), world(), keys(), np.random.default_rng(seed), given)


@cache
def found(seed: int) -> Postures:
    return search(seed).first()


def tips(q: Array) -> dict[str, pin.SE3]:
    data = robot().model.createData()
    pin.framesForwardKinematics(robot().model, data, q)
    return {name: data.oMf[each.tip_frame_id] for name, each in robot().fingers.items()}


@pytest.fixture(params=range(3))
def postures(request: pytest.FixtureRequest) -> Postures:
    return found(request.param)


def test_tips_are_at_their_contacts(postures: Postures) -> None:
    for key, q in zip(keys(), postures.q, strict=True):
        at = tips(q)
        for finger, contact in key.contacts.items():
            radius = robot().fingers[finger].tip_radius
            centre = key.position + key.rotation @ (contact.point - radius * contact.normal)
            np.testing.assert_allclose(at[finger].translation, centre, atol=1e-9)


def test_contacts_are_on_the_pads_and_seen_in_the_hold_s_direction(postures: Postures) -> None:
    for key, q in zip(keys(), postures.q, strict=True):
        at = tips(q)
        for finger, contact in key.contacts.items():
            seen = at[finger].rotation.T @ key.rotation @ contact.normal
            hold = postures.holds[finger, contact.name]
            # radians; 1e-11 m of the projection over tips of some millimetres
            np.testing.assert_allclose(seen, hold.axis_in_tip, atol=1e-8)
            tip = robot().fingers[finger]
            assert np.arccos(tip.pad @ seen) <= tip.pad_cone + ROLL_RAD


def test_a_lasting_contact_is_seen_in_one_direction(postures: Postures) -> None:
    lasting = held_on(keys())
    assert len(lasting) == 6
    for finger, k, following in lasting:
        seen = [
            tips(postures.q[i])[finger].rotation.T
            @ keys()[i].rotation
            @ keys()[i].contacts[finger].normal
            for i in (k, following)
        ]
        np.testing.assert_allclose(*seen, atol=1e-8)


def test_limits_couplings_and_clearance_are_kept(postures: Postures) -> None:
    q = postures.q
    assert np.all((q >= robot().lower) & (q <= robot().upper))
    assert robot().couplings
    for i, k in robot().couplings:
        assert np.all(q[:, i] <= q[:, k])
    everything, gaps = world(), []
    for key, each in zip(keys(), q, strict=True):
        held = everything.holding(frozenset(key.contacts))
        assert held.free(each, key.rotation, key.position)
        gaps.append(held.clearance(each, key.rotation, key.position)[0])
    assert min(gaps) >= everything.clearance_min
    assert postures.clearance == pytest.approx(min(gaps), abs=1e-12)


def test_every_posture_is_away_from_singularity(postures: Postures) -> None:
    values = []
    for key, q in zip(keys(), postures.q, strict=True):
        data = robot().model.createData()
        pin.framesForwardKinematics(robot().model, data, q)
        palm = key.rotation.T @ data.oMf[robot().palm_frame_id].rotation
        holds = [postures.holds[finger, each.name] for finger, each in key.contacts.items()]
        task = TaskJacobian(robot(), holds, palm_target=palm)
        choice = choose_palm_rows(task, q, key.rotation, key.position)
        values.append(choice.smallest_singular_value)
    assert min(values) >= SINGULAR_VALUE_MIN
    assert postures.singular_value == pytest.approx(min(values), rel=1e-9)


def test_same_seed_same_postures() -> None:
    again, other = search(0).first(), found(1)
    np.testing.assert_array_equal(again.q, found(0).q)
    assert again.holds.keys() == found(0).holds.keys()
    assert not np.array_equal(other.q, again.q)


def test_candidates_go_on_and_the_record_counts_them() -> None:
    each = search(2, starts=12)
    candidates = list(each.candidates())
    record = each.record
    assert record.starts == 12
    assert record.found == len(candidates) >= 1
    assert record.found + sum(record.failures.values()) == record.starts
    np.testing.assert_array_equal(candidates[0].q, found(2).q)


@pytest.mark.parametrize("away", [(0.0, 3.0, 0.0), (3.0, 0.0, 0.0)])
def test_contacts_out_of_reach_are_named_with_their_distance(
    away: tuple[float, float, float],
) -> None:
    far = keys(away)
    each = PostureSearch(robot(), None, far, np.random.default_rng(0), PostureOptions(starts=4))
    with pytest.raises(InfeasibleError) as caught:
        each.first()
    distance, contact = each.record.missed
    assert contact in {c.name for c in far[-1].contacts.values()}
    assert f"{contact} stays {1e3 * distance:.1f} mm off" in str(caught.value)
    assert "4 starts" in caught.value.what
    assert caught.value.mend
    # the arm's reach is less than a metre, and the knife lies within it
    assert 1.5 < distance < 3.0


def test_no_start_no_posture() -> None:
    with pytest.raises(InfeasibleError, match="no posture in 0 starts; most often: no start"):
        search(0, starts=0).first()


def test_a_bound_that_nothing_keeps_is_named() -> None:
    options = PostureOptions(starts=6, singular_value_min=1.0)
    each = PostureSearch(robot(), None, keys(), np.random.default_rng(0), options)
    with pytest.raises(InfeasibleError) as caught:
        each.first()
    assert "singular: task Jacobian" in each.record.failures
    assert "6 starts; most often: " in caught.value.what


def test_a_robot_without_a_finger() -> None:
    fingers = {name: each for name, each in robot().fingers.items() if name != "middle"}
    lame = replace(robot(), fingers=fingers)
    with pytest.raises(UnknownNameError, match=r"^key 3: unknown finger 'middle'.*thumb"):
        PostureSearch(lame, None, keys(), np.random.default_rng(0))


def test_a_chain_settles_where_it_is() -> None:
    chain = PostureChain(robot(), world(), keys(), SINGULAR_VALUE_MIN)
    settled = chain.settle(found(0).q, 30)
    assert isinstance(settled, Postures)
    # closing the chain exactly moved it a little off the fit's end; Coal's last digits vary
    start = PostureResiduals(robot(), keys(), world()).normal_equations(found(0).q).cost
    assert settled.cost <= start * (1.0 + 1e-6)
    # five joints per finger and eleven more: the rest may drift towards comfort
    assert np.abs(settled.q - found(0).q).max() < 0.2


def test_a_chain_says_by_how_much_it_misses() -> None:
    chain = PostureChain(robot(), None, keys((0.0, 3.0, 0.0)), SINGULAR_VALUE_MIN)
    refused = chain.reach(found(0).q, 10)
    assert isinstance(refused, Refused)
    assert refused.kind == "reach"
    assert refused.reason == f"reach: {refused.about}"
    assert 1.5 < refused.distance < 3.0


def test_a_collision_names_its_pair() -> None:
    """A clearance of 5 cm cannot be kept by fingers side by side."""
    wide = CollisionWorld(robot(), scene().tool, scene().table.height, 0.05)
    refused = PostureChain(robot(), wide, keys(), SINGULAR_VALUE_MIN).settle(found(0).q, 10)
    assert isinstance(refused, Refused)
    assert refused.kind == "collision"
    assert " - " in refused.about
