"""The grasp map adds forces and moments, and its transpose moves contact points."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.contacts import grasp_map
from pivotgait.contacts.grasp_map import skew

Array = NDArray[np.float64]
ROUNDING = 1e-14
"""Sums of a dozen products of order 1."""


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def test_skew_is_the_cross_product(rng: np.random.Generator) -> None:
    v, u = rng.normal(size=(2, 50, 3))
    matrix = skew(v)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", matrix, u), np.cross(v, u), atol=ROUNDING)
    np.testing.assert_array_equal(matrix, -np.swapaxes(matrix, 1, 2))
    np.testing.assert_array_equal(skew(-v), -matrix)


def test_skew_of_a_turned_vector_is_the_turned_matrix(rng: np.random.Generator) -> None:
    v, turn = rng.normal(size=3), Rotation.random(rng=rng).as_matrix()
    np.testing.assert_allclose(skew(turn @ v), turn @ skew(v) @ turn.T, atol=ROUNDING)


def test_skew_of_a_cross_product_is_the_commutator(rng: np.random.Generator) -> None:
    a, b = rng.normal(size=(2, 3))
    commutator = skew(a) @ skew(b) - skew(b) @ skew(a)
    np.testing.assert_allclose(skew(np.cross(a, b)), commutator, atol=ROUNDING)


@pytest.mark.parametrize("contacts", [1, 2, 4, 6])
def test_map_gives_the_sum_of_forces_and_of_moments(
    rng: np.random.Generator, contacts: int
) -> None:
    lever, force = rng.normal(size=(2, 8, contacts, 3))
    wrench = np.einsum("nij,nj->ni", grasp_map(lever), force.reshape(8, -1))
    np.testing.assert_allclose(wrench[:, :3], force.sum(axis=1), atol=ROUNDING)
    np.testing.assert_allclose(wrench[:, 3:], np.cross(lever, force).sum(axis=1), atol=ROUNDING)


def test_power_of_forces_equals_power_of_their_wrench(rng: np.random.Generator) -> None:
    lever, force = rng.normal(size=(2, 5, 3))
    velocity, omega = rng.normal(size=(2, 3))
    g = grasp_map(lever)
    point_velocity = g.T @ np.concatenate((velocity, omega))
    # the transpose gives each contact point the velocity of the rigid body there
    rigid = velocity + np.cross(omega, lever)
    np.testing.assert_allclose(point_velocity.reshape(5, 3), rigid, atol=ROUNDING)
    power_of_forces = float(np.sum(force * rigid))
    power_of_wrench = float((g @ force.ravel()) @ np.concatenate((velocity, omega)))
    assert power_of_forces == pytest.approx(power_of_wrench, abs=10 * ROUNDING)


@pytest.mark.parametrize(("contacts", "rank"), [(1, 3), (2, 5), (3, 6), (4, 6)])
def test_rank_tells_what_contacts_can_resist(
    rng: np.random.Generator, contacts: int, rank: int
) -> None:
    # two points leave the moment about the line through them free: eq. (3) needs a third
    lever = rng.normal(size=(contacts, 3))
    assert np.linalg.matrix_rank(grasp_map(lever)) == rank


def test_a_squeeze_along_the_line_of_two_contacts_does_nothing(rng: np.random.Generator) -> None:
    lever = rng.normal(size=(2, 3))
    pull = lever[1] - lever[0]
    np.testing.assert_allclose(grasp_map(lever) @ np.concatenate((pull, -pull)), 0, atol=ROUNDING)
