"""Maps agree with verdicts one by one; shares of draws behave like probabilities."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.feasibility import (
    MapAxis,
    Question,
    Variants,
    friction_drop,
    robust_margins,
    share_map,
    static_verdicts,
    tightest_limit,
    trace_map,
    trace_slices,
)
from pivotgait.models import load_scene
from tests.feasibility.cases import random_grasps

SCENE = load_scene("knife")
VARIANTS = Variants(SCENE)
ALONG = MapAxis("contacts.middle_flat.along_m", 0.005, 0.110)
AROUND = MapAxis("contacts.middle_flat.around_deg", 60.0, 200.0)
FRICTION = MapAxis("contacts.*.friction", 0.2, 1.2)
MASS = MapAxis("tool.mass_scale", 0.2, 5.0)


@pytest.fixture(scope="module")
def places():
    return trace_map(VARIANTS, Question.about(SCENE), ALONG, AROUND, tolerance=1 / 32)


def test_each_point_has_the_verdict_of_its_scene(places):
    rng = np.random.default_rng(0)
    known = np.flatnonzero(~np.isnan(places.feasible))
    for k in rng.choice(known, 25, replace=False).tolist():
        along, around = places.points[k].tolist()
        scene = VARIANTS.scene_with({ALONG.parameter: along, AROUND.parameter: around})
        verdict = static_verdicts(places.question.grasps(scene), exact=True)
        assert places.value[k] == pytest.approx(float(verdict.depth[0]), rel=1e-6, abs=1e-9)
        assert places.feasible[k] == verdict.feasible[0]


def test_a_map_takes_fewer_points_than_a_grid_and_finds_the_same_area(places):
    n = round(1 / places.tolerance) + 1
    share = np.linspace(0.0, 1.0, n)
    changes = [
        {ALONG.parameter: a, AROUND.parameter: b}
        for a in ALONG.at(share).tolist()[::2]
        for b in AROUND.at(share).tolist()[::2]
    ]
    from pivotgait.feasibility.maps import scenes_at

    scenes, _ = scenes_at(VARIANTS, changes)
    brute = places.question.answers(scenes).feasible.sum() / len(changes)
    assert places.area == pytest.approx(brute, abs=0.03)
    assert places.grid == n * n
    assert places.evaluated < 0.6 * places.grid
    assert 0.05 < places.area < 0.95


def test_places_off_the_handle_have_no_verdict(places):
    off = np.isnan(places.feasible)
    assert off.any()
    assert np.all(np.isnan(places.value[off]))
    assert places.points[off, 0].max() < 0.012


def test_the_longer_the_lift_the_more_friction_levels_hold():
    question = Question.about(SCENE, phase="00_lift")
    duration = MapAxis("lift.duration_s", 0.1, 1.5)
    found = trace_map(VARIANTS, question, duration, FRICTION, tolerance=1 / 16)
    feasible = found.points[found.feasible == 1.0]
    assert 0.0 < found.area < 1.0
    # the border descends: least friction for fast lifts is above that for slow ones
    fast = feasible[feasible[:, 0] < 0.4, 1]
    assert feasible[feasible[:, 0] > 1.0, 1].min() <= (fast.min() if fast.size else np.inf)


def test_at_a_margins_border_the_reserve_is_all_that_is_left():
    question = Question.about(SCENE, phase="00_lift", quantity="margin")
    heavy = MapAxis(MASS.parameter, 1.0, 5.0)  # where friction binds
    found = trace_map(VARIANTS, question, FRICTION, heavy, tolerance=1 / 16)
    reserve = SCENE.allocation.friction_reserve
    assert found.value[found.feasible == 1.0].min() >= reserve - 1e-3
    assert found.value[found.feasible == 0.0].max() <= reserve + 1e-3


def test_turns_are_the_smallest_tilts_and_zero_where_it_holds():
    at_rest, turning = (Question.about(SCENE, quantity=each) for each in ("depth", "turn"))
    scenes = [VARIANTS.scene_with({AROUND.parameter: around}) for around in (90.0, 140.0)]
    depth, turn = at_rest.answers(scenes).value, turning.answers(scenes).value
    assert depth[0] < 0.0 < depth[1]
    assert turn[0] > 5.0
    assert turn[1] == 0.0
    short = Question.about(SCENE, quantity="turn", turn_max_deg=turn[0] / 2.0)
    assert short.answers(scenes).feasible.tolist() == [0.0, 1.0]


def test_slices_are_maps_with_one_more_value_and_fingers_can_be_left_out():
    question = Question.about(SCENE, phase="02_addition")
    slices = [("removed", ""), ("removed", "thumb"), ("removed", "index")]
    table = MapAxis("table.friction", 0.1, 1.0)
    maps = trace_slices(VARIANTS, question, FRICTION, table, slices, tolerance=1 / 16)
    assert [each.fixed["removed"] for each in maps] == ["", "thumb", "index"]
    assert maps[0].area >= max(each.area for each in maps[1:])
    third = trace_slices(
        VARIANTS, question, FRICTION, table, [(MASS.parameter, 3.0)], tolerance=1 / 8
    )[0]
    alone = trace_map(
        VARIANTS, question, FRICTION, table, fixed={MASS.parameter: 3.0}, tolerance=1 / 8
    )
    assert np.array_equal(third.value, alone.value)


def test_shares_of_draws():
    question, rng = Question.about(SCENE, phase="00_lift"), np.random.default_rng
    spread = {"contacts.*.friction": 0.1, MASS.parameter: 0.2}
    options = {"cells": 3, "draws": 8}
    found = share_map(VARIANTS, question, FRICTION, MASS, spread, rng(1), **options)
    again = share_map(VARIANTS, question, FRICTION, MASS, spread, rng(1), **options)
    assert np.array_equal(found.share, again.share)
    assert np.nanmin(found.share) == 0.0
    assert np.nanmax(found.share) == 1.0
    # nothing spreads far: as good as certain on both sides of the border
    sharp = share_map(VARIANTS, question, FRICTION, MASS, {MASS.parameter: 1e-9}, rng(1), **options)
    assert set(np.unique(sharp.share).tolist()) <= {0.0, 1.0}
    assert np.all(sharp.standard_error == 0.0)


def test_the_tightest_limit_is_the_same_alone_and_in_a_batch():
    grasps = random_grasps(np.random.default_rng(3), 12, 4)
    batch = static_verdicts(grasps, exact=True).tightest
    for k, found in enumerate(batch):
        alone = tightest_limit(grasps.take(np.array([k])))
        assert found == (alone.kind, alone.contact if alone.kind != "wrench" else "")
    assert static_verdicts(grasps).tightest == ()


def test_the_drop_of_friction_alone_is_that_of_all_margins():
    grasps = random_grasps(np.random.default_rng(5), 20, 4)
    assert np.array_equal(friction_drop(grasps), robust_margins(grasps).friction_drop)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: MapAxis("table.friction", 1.0, 0.5), "smaller value first"),
        (lambda: MapAxis("table.friction", 0.0, float("inf")), "smaller value first"),
        (lambda: Question.about(SCENE, phase="01_relocation"), "unknown phase"),
        (lambda: Question.about(SCENE, gait="slow"), "unknown gait"),
        (lambda: Question.about(SCENE, quantity="luck"), "unknown quantity"),
        (lambda: Question.about(SCENE, removed="index"), "unknown finger"),
        (lambda: Question.about(SCENE, removed="thumb"), "one finger alone"),
        (lambda: Question.about(SCENE, quantity="turn", turn_max_deg=90.0), "give 0 to 60"),
        (lambda: trace(FRICTION, FRICTION), "set twice"),
        (lambda: trace(FRICTION, MASS, tolerance=0.5), "tolerance"),
        (lambda: trace(FRICTION, MASS, tolerance=1e-6), "tolerance"),
        (lambda: trace(FRICTION, MapAxis("table.fricton", 0.1, 0.2)), "did you mean 'friction'"),
        (lambda: shares({}), "standard deviation"),
        (lambda: shares({"table.friction": 0.0}), "standard deviation"),
        (lambda: shares({"table.fricton": 0.1}), "did you mean 'friction'"),
    ],
)
def test_nonsense_is_refused(make, words):
    with pytest.raises((InputError, UnknownNameError)) as caught:
        make()
    assert words in str(caught.value)


def trace(across, up, **options):
    return trace_map(VARIANTS, Question.about(SCENE), across, up, **options)


def shares(spread):
    question = Question.about(SCENE)
    return share_map(VARIANTS, question, FRICTION, MASS, spread, np.random.default_rng(0))


def test_the_smallest_turn_does_not_hang_on_the_directions_of_the_scan(monkeypatch):
    from pivotgait.feasibility import turns

    # just below the friction with which no turn is needed, few headings lead to the smallest
    changed = {"contacts.*.friction": 0.75, "allocation.friction_reserve": 0.0}
    scenes = [VARIANTS.scene_with(changed)]
    question = Question.about(SCENE, quantity="turn")
    found = question.answers(scenes).value
    assert 0.0 < found[0] < 10.0
    monkeypatch.setattr(turns, "DIRECTIONS", 2 * turns.DIRECTIONS)
    assert question.answers(scenes).value == pytest.approx(found, abs=0.02)
