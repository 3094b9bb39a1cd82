"""The descent: never upwards, never out of the joint limits, still where nothing is to gain."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.planning.posture_residuals import PostureResiduals
from pivotgait.planning.posture_solver import fit_postures
from tests.planning.knife_keys import anywhere, keys, robot, world


@pytest.mark.parametrize("collisions", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_cost_falls_with_every_step_within_limits(collisions: bool, seed: int) -> None:
    residuals = PostureResiduals(robot(), keys(), world() if collisions else None)
    q = anywhere(np.random.default_rng(seed), len(keys()))
    cost = residuals.normal_equations(q).cost
    for _ in range(8):
        fit = fit_postures(residuals, q, iterations=1)
        assert fit.iterations == 1
        assert fit.cost < cost
        assert np.all((fit.postures >= robot().lower) & (fit.postures <= robot().upper))
        # Coal's distances depend in the last digits on what was asked before
        assert residuals.normal_equations(fit.postures).cost == pytest.approx(fit.cost, rel=1e-6)
        q, cost = fit.postures, fit.cost


@pytest.mark.parametrize("seed", range(5))
def test_an_end_is_stationary(seed: int) -> None:
    """Where no limit holds a joint, the gradient has vanished against that of the start."""
    residuals = PostureResiduals(robot(), keys())
    start = robot().home + 0.1 * np.random.default_rng(seed).normal(size=(4, robot().nv))
    # The wish for home is weak beside the tips': its directions take hundreds of damped steps.
    end = fit_postures(residuals, start, iterations=400, tolerance=1e-12)
    inside = ((end.postures > robot().lower) & (end.postures < robot().upper)).ravel()
    gradient = residuals.normal_equations(end.postures).gradient[inside]
    before = residuals.normal_equations(start).gradient
    assert np.linalg.norm(gradient) < 1e-6 * np.linalg.norm(before)
    again = fit_postures(residuals, end.postures)
    assert 0.5 * end.cost < again.cost <= end.cost


def test_a_start_beyond_the_limits_is_brought_back() -> None:
    residuals = PostureResiduals(robot(), keys())
    for iterations in (0, 1, 20):
        fit = fit_postures(residuals, np.tile(robot().upper + 0.3, (4, 1)), iterations=iterations)
        assert fit.iterations <= iterations
        assert np.all((fit.postures >= robot().lower) & (fit.postures <= robot().upper))


def test_joints_pushed_against_a_limit_leave_the_others_free() -> None:
    """From a corner of the limits one step still gains as much as the free joints can."""
    residuals = PostureResiduals(robot(), keys())
    corner = np.tile(np.where(np.arange(robot().nv) % 2, robot().upper, robot().lower), (4, 1))
    before = residuals.normal_equations(corner)
    pushed = np.where(corner == robot().lower, before.gradient.reshape(corner.shape) > 0.0, False)
    pushed |= (corner == robot().upper) & (before.gradient.reshape(corner.shape) < 0.0)
    assert pushed.any()
    assert not pushed.all()
    after = fit_postures(residuals, corner, iterations=1)
    np.testing.assert_array_equal(after.postures[pushed], corner[pushed])
    assert np.any(after.postures[~pushed] != corner[~pushed])
    assert after.cost < before.cost
