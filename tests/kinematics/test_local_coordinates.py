"""Laws of the local coordinates' angles and of the map from angular velocity to their rates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.kinematics import (
    angles_from_rotation,
    rate_map,
    rate_map_derivative,
    rotation_from_angles,
)
from pivotgait.kinematics.local_coordinates import SMALLEST_COS_PSI, rate_map_drift

Array = NDArray[np.float64]
Differences = Callable[[Callable[[float], Array]], tuple[Array, Array]]
EDGE = float(np.arccos(SMALLEST_COS_PSI))


def random_angles(count: int) -> Array:
    rng = np.random.default_rng(5)
    return rng.uniform(-1.0, 1.0, (count, 3)) * [np.pi, 0.95 * EDGE, np.pi]


SOME = [
    *random_angles(6),
    np.zeros(3),
    np.array([np.pi - 1e-4, 0.3, -0.2]),
    np.array([-np.pi + 1e-4, 0.3, -0.2]),
    np.array([0.4, -0.2, np.pi - 1e-4]),
    np.array([0.4, 0.999 * EDGE, 1.0]),
    np.array([0.4, -0.999 * EDGE, 1.0]),
]


def wrapped(angle: Array) -> Array:
    return np.angle(np.exp(1j * angle))


def test_rotation_is_the_product_of_turns_about_x_y_and_z() -> None:
    angles = random_angles(50)
    # scipy's capital letters: intrinsic turns, x first.
    expected = Rotation.from_euler("XYZ", angles[:, ::-1]).as_matrix()
    np.testing.assert_allclose(rotation_from_angles(angles), expected, atol=1e-15)


def test_angles_come_back() -> None:
    angles = np.concatenate((random_angles(200), SOME))
    back = angles_from_rotation(rotation_from_angles(angles))
    np.testing.assert_allclose(wrapped(back - angles), 0.0, atol=1e-13)


@pytest.mark.parametrize("theta", [np.pi, -np.pi, np.nextafter(np.pi, 0.0)])
def test_half_turn_about_the_normal_has_coordinates(theta: float) -> None:
    angles = angles_from_rotation(rotation_from_angles(np.array([theta, 0.1, -0.2])))
    np.testing.assert_allclose(abs(angles[0]), np.pi, atol=1e-15)
    np.testing.assert_allclose(angles[1:], [0.1, -0.2], atol=1e-15)


def test_shapes_follow_the_leading_axes() -> None:
    angles = random_angles(6).reshape(2, 3, 3)
    whole = rate_map_derivative(angles, angles)
    assert rotation_from_angles(angles).shape == whole.shape == (2, 3, 3, 3)
    np.testing.assert_array_equal(whole[1, 2], rate_map_derivative(angles[1, 2], angles[1, 2]))


@pytest.mark.parametrize("angles", SOME)
def test_rate_map_is_the_derivative_of_the_angles(angles: Array, differences: Differences) -> None:
    rotation, E = rotation_from_angles(angles), rate_map(angles)
    for axis, column in zip(np.eye(3), E.T, strict=True):

        def offset(time: float, axis: Array = axis) -> Array:
            turned = pin.exp3(0.01 * time * axis) @ rotation
            return wrapped(angles_from_rotation(turned) - angles)

        np.testing.assert_allclose(differences(offset)[0] / 0.01, column, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("angles", SOME)
def test_derivative_of_the_rate_map(angles: Array, differences: Differences) -> None:
    rates = np.array([0.7, -0.013, 0.4])
    numeric = differences(lambda time: rate_map(angles + time * rates))[0]
    analytic = rate_map_derivative(angles, rates)
    np.testing.assert_allclose(analytic, numeric, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("angles", SOME)
def test_drift_of_the_rate_map_follows_from_the_rates(angles: Array) -> None:
    omega = np.array([0.7, -0.4, 1.3])
    rates = rate_map(angles) @ omega
    drift = rate_map_drift(np.tan(angles[1]), 1.0 / np.cos(angles[1]), rates.tolist())
    expected = rate_map_derivative(angles, rates) @ omega
    np.testing.assert_allclose(drift, expected, rtol=1e-10, atol=1e-12)


def test_spin_about_the_normal_moves_theta_alone() -> None:
    angles = random_angles(20)
    normal = rotation_from_angles(angles)[..., 2]
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", rate_map(angles), normal), np.eye(3)[[0] * 20], atol=1e-13
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("beyond", [0.01, 1.0])
def test_singular_orientations_are_refused(sign: float, beyond: float) -> None:
    psi = sign * (EDGE + beyond * (np.pi / 2 - EDGE))
    with pytest.raises(SingularCoordinatesError, match="90 degrees") as error:
        angles_from_rotation(rotation_from_angles(np.array([0.3, psi, 0.2])))
    np.testing.assert_allclose(error.value.angle, abs(psi), atol=1e-9)
