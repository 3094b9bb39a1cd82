"""Derivatives of the depth by multipliers equal finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.feasibility import sensitivity
from tests.feasibility.cases import random_grasps

STEP = 1e-5
GRASPS = random_grasps(np.random.default_rng(21), 60, 4)
FOUND = sensitivity(GRASPS)


def _close(numeric: np.ndarray, exact: np.ndarray) -> None:
    """Equal but where the depth has a kink within the step: rarely."""
    miss = np.abs(numeric - exact) > 1e-3 * (1.0 + np.abs(exact))
    assert miss.mean() < 0.02, np.nonzero(miss)
    assert np.abs(exact).max() > 1e-2


def _difference(change) -> np.ndarray:
    return (sensitivity(change(STEP)).depth - sensitivity(change(-STEP)).depth) / (2.0 * STEP)


@pytest.mark.parametrize("name", ["normal_min", "normal_max"])
@pytest.mark.parametrize("contact", range(4))
def test_by_force_bounds(name, contact):
    unit = np.eye(4)[contact]
    value = getattr(GRASPS.problem, name)
    numeric = _difference(lambda step: GRASPS.changed(**{name: value + step * unit}))
    exact = getattr(FOUND, name)[:, contact]
    miss = np.abs(numeric - exact) > 1e-3
    assert miss.mean() < 0.02


@pytest.mark.parametrize("contact", range(4))
def test_by_friction(contact):
    unit = np.eye(4)[contact]
    numeric = _difference(lambda step: GRASPS.changed(friction=GRASPS.friction + step * unit))
    _close(numeric, FOUND.friction[:, contact])


@pytest.mark.parametrize("axis", range(6))
def test_by_the_wrench(axis):
    unit, wrench = 0.1 * np.eye(6)[axis], GRASPS.problem.wrench
    numeric = _difference(lambda step: GRASPS.changed(wrench=wrench + step * unit))
    _close(10.0 * numeric, FOUND.wrench[:, axis])


@pytest.mark.parametrize("contact", range(4))
def test_by_the_contact_points(contact):
    way = np.random.default_rng(contact).normal(size=(60, 3))
    move = np.zeros((60, 4, 3))
    move[:, contact] = 0.1 * way
    lever = GRASPS.problem.lever
    numeric = _difference(lambda step: GRASPS.changed(lever=lever + step * move))
    _close(10.0 * numeric, np.sum(FOUND.lever[:, contact] * way, axis=1))


@pytest.mark.parametrize("contact", range(4))
def test_by_the_normals(contact):
    normals = GRASPS.problem.normals
    way = np.cross(np.random.default_rng(contact).normal(size=(60, 3)), normals[:, contact])

    def tilted(step: float):
        other = np.array(normals)
        other[:, contact] += step * way
        other[:, contact] /= np.linalg.norm(other[:, contact], axis=1, keepdims=True)
        return GRASPS.changed(normals=other)

    _close(_difference(tilted), np.sum(FOUND.normals[:, contact] * way, axis=1))


def test_a_grasp_out_of_reach_has_none():
    found = sensitivity(random_grasps(np.random.default_rng(0), 4, 2))
    assert np.all(np.isinf(found.depth))
    assert np.all(np.isnan(found.wrench))


def test_a_small_gain_of_friction_gives_what_was_promised():
    gain = sensitivity(GRASPS.changed(friction=GRASPS.friction + 1e-3)).depth - FOUND.depth
    promised = 1e-3 * FOUND.friction.sum(axis=1)
    assert np.all(gain >= -1e-9)
    assert np.allclose(gain, promised, atol=2e-5, rtol=0.1)
