"""Robust margins are edges: feasible just before them, infeasible just beyond."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.feasibility import robust_margins, static_verdicts
from pivotgait.feasibility.edges import last_feasible
from pivotgait.feasibility.robustness import sensing_share
from pivotgait.forces import LinearRows, allocate
from tests.feasibility.cases import random_grasps

GRASPS = random_grasps(np.random.default_rng(11), 60, 4)
FOUND = robust_margins(GRASPS)
HELD = static_verdicts(GRASPS).feasible


def test_edges_of_known_lines():
    start, limit = np.zeros(5), np.array([1.0, 1.0, -2.0, 1.0, 1.0])
    edge = np.array([0.3, 2.0, -0.7, -1.0, 1e-3])

    def holds(line, value):
        return np.where(edge[line] >= 0.0, value <= edge[line], (value >= edge[line]))

    holds_until = last_feasible(start, limit, holds, rounds=9)
    assert holds_until[[0, 2, 4]] == pytest.approx(edge[[0, 2, 4]], abs=1e-5)
    assert holds_until[1] == 1.0
    assert np.all(np.abs(holds_until[[0, 4]]) <= edge[[0, 4]])
    never = last_feasible(start, limit, lambda line, value: np.zeros(len(line), dtype=bool))
    assert np.all(np.isnan(never))


@pytest.mark.parametrize(
    ("name", "whose"),
    [
        ("friction_drop", [1, 1, 1, 1]),
        ("finger_friction_drop", [0, 1, 1, 1]),
        ("table_friction_drop", [1, 0, 0, 0]),
    ],
)
def test_a_drop_of_friction(name, whose):
    drop = getattr(FOUND, name)
    assert np.array_equal(drop >= 0.0, HELD)
    at = np.nonzero(np.isfinite(drop) & (drop < 1.0))[0]
    some = GRASPS.take(at)
    for nudge, good in ((1.002, True), (0.998, False)):
        factor = nudge * (1.0 - drop[at, None])
        mu = np.where(whose, factor, 1.0) * some.friction
        assert np.all(static_verdicts(some.changed(friction=mu)).feasible == good)


def test_the_drop_of_all_friction_is_the_best_margin():
    for k in np.nonzero(HELD)[0][:8]:
        one = GRASPS.take(np.array([k]))
        # the margin objective wants one friction for all samples
        problem = replace(one.problem, friction=one.friction[0], objective="margin")
        best = allocate(problem, "clarabel").objective[0]
        assert FOUND.friction_drop[k] == pytest.approx(best, abs=1e-3)


@pytest.mark.parametrize(("name", "sign"), [("mass_increase", 1.0), ("mass_decrease", -1.0)])
def test_an_error_of_the_mass(name, sign):
    error = getattr(FOUND, name)
    assert np.array_equal(np.isnan(error), ~HELD)
    at = np.nonzero(HELD & (error < (9.0 if sign > 0.0 else 1.0)))[0]
    assert at.size > 3
    some = GRASPS.take(at)
    for nudge, good in ((-1e-3, True), (1e-3, False)):
        load = (1.0 + sign * (error[at, None] + nudge)) * some.problem.wrench
        found = static_verdicts(some.changed(wrench=load)).feasible
        assert np.all(found[error[at] > 2e-3] == good)


def test_the_tip_can_be_pressed_so_hard_and_no_harder():
    reserve, low = FOUND.lift_off_N, GRASPS.problem.normal_min
    at = np.nonzero(HELD & (reserve < (GRASPS.problem.normal_max - low)[:, 0] - 0.01))[0]
    some = GRASPS.take(at)
    for nudge, good in ((-1e-3, True), (1e-3, False)):
        least = np.array(some.problem.normal_min)
        least[:, 0] += reserve[at] + nudge
        found = static_verdicts(some.changed(normal_min=np.maximum(least, 0.0))).feasible
        assert np.all(found[reserve[at] > 2e-3] == good)


def test_a_wrongly_sensed_finger_is_made_up_for():
    """With any finger's normal force off by the share's error, the others still hold the tool."""
    verdicts = static_verdicts(GRASPS, exact=True)
    checked = 0
    for k in np.nonzero(HELD)[0]:
        share = FOUND.sensing_share[k]
        assert 0.0 <= share <= 2.0
        force = verdicts.force[k]
        normals = GRASPS.problem.normals[k]
        for finger in range(1, 4):
            normal = force[finger] @ normals[finger]
            slope = np.linalg.norm(force[finger] - normal * normals[finger]) / normal
            angle, error = np.radians(30.0) * share, 0.25 * share
            for sign in (1.0, -1.0):
                wrong = (1.0 + sign * error) * (np.cos(angle) + sign * slope * np.sin(angle))
                fixed = np.full((1, 4), np.nan)
                fixed[0, finger] = 0.999 * normal * wrong + 0.001 * normal
                low, high = (getattr(GRASPS.problem, n)[k] for n in ("normal_min", "normal_max"))
                if not low[finger] <= fixed[0, finger] <= high[finger]:
                    pytest.fail("the true force would leave its bounds")
                one = GRASPS.take(np.array([k])).changed(normal_fixed=fixed)
                assert static_verdicts(one).feasible[0]
                checked += 1
    assert checked > 60


def test_the_share_of_known_numbers():
    # straight force: size errs by 25 % s times the cosine of 30 s degrees
    share = sensing_share(np.zeros(1), np.ones(1), np.array([0.5]), np.array([10.0]))
    s = float(share[0])
    assert (1.0 - 0.25 * s) * np.cos(np.radians(30.0 * s)) == pytest.approx(0.5, abs=2e-3)
    none = sensing_share(np.zeros(1), np.ones(1), np.ones(1), np.ones(1))
    assert none[0] < 2e-3


def test_the_infeasible_know_how_much_friction_is_missing():
    missing = FOUND.friction_drop[~HELD]
    assert np.all(missing < 0.0)
    assert np.isfinite(missing).any()
    assert np.all(np.isnan(FOUND.sensing_share[~HELD]))


@pytest.mark.slow
def test_weaker_joints_up_to_the_drop():
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(60, 6, 12))
    middle = np.einsum("brf,bf->br", matrix, static_verdicts(GRASPS).force.reshape(60, 12))
    middle = np.where(HELD[:, None], middle, 0.0) + 0.5
    rows = LinearRows(matrix, middle - 1.0, middle + 1.0)
    drop = robust_margins(GRASPS.changed(rows=rows)).torque_drop
    assert np.all(np.isnan(FOUND.torque_drop))
    at = np.nonzero(np.isfinite(drop) & (drop < 1.0))[0]
    assert at.size > 10
    assert np.all(np.isinf(drop[~HELD]))
    for nudge, good in ((1.002, True), (0.998, False)):
        half = nudge * (1.0 - drop[at])[:, None]
        some = LinearRows(matrix[at], middle[at] - half, middle[at] + half)
        found = static_verdicts(GRASPS.take(at).changed(rows=some)).feasible
        assert np.all(found == good)
