"""A finger's distance from its singularity is a singular value, and its gradient is exact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame
from pivotgait.kinematics.dexterity import dexterity
from pivotgait.models import Robot

Array = NDArray[np.float64]
Differences = Callable[[Callable[[float], Array]], tuple[Array, Array]]
LENGTH = 0.03
EVERY_FINGER = pytest.mark.parametrize("name", ["thumb", "index", "middle"])


def tip_jacobian(robot: Robot, q: Array, name: str) -> Array:
    data, place = robot.model.createData(), robot.fingers[name].tip_frame_id
    return pin.computeFrameJacobian(robot.model, data, q, place, pin.LOCAL_WORLD_ALIGNED)


def direction(grip: Any) -> Array:
    normal = grip.rng.normal(size=3)
    return normal / np.linalg.norm(normal)


def smallest_of_five_rows(jacobian: Array, normal: Array, own: tuple[int, ...]) -> float:
    """By singular value decomposition, in the axes of the contact."""
    axes = contact_frame(normal).T
    rows = np.concatenate((axes @ jacobian[:3, own], LENGTH * (axes @ jacobian[3:, own])[:2]))
    return float(np.linalg.svd(rows, compute_uv=False)[-1])


def columns(robot: Robot, name: str, carried: bool) -> tuple[int, ...]:
    own = robot.fingers[name].columns
    return (*robot.palm_columns, *own) if carried else own


@EVERY_FINGER
@pytest.mark.parametrize("carried", [False, True], ids=["own joints", "with arm and wrist"])
def test_it_is_the_smallest_singular_value(grip: Any, name: str, carried: bool) -> None:
    q, normal, own = grip.near(), direction(grip), columns(grip.robot, name, carried)
    jacobian = tip_jacobian(grip.robot, q, name)
    sigma, _ = dexterity(jacobian, normal, own, LENGTH)
    # of the square's eigenvalue: rounding 1e-16 m^2 over 2 sigma
    assert sigma == pytest.approx(smallest_of_five_rows(jacobian, normal, own), rel=1e-8, abs=1e-9)


@EVERY_FINGER
@pytest.mark.parametrize("carried", [False, True], ids=["own joints", "with arm and wrist"])
def test_gradient_is_that_of_finite_differences(
    grip: Any, name: str, carried: bool, differences: Differences
) -> None:
    robot, q, normal = grip.robot, grip.near(), direction(grip)
    own = columns(robot, name, carried)
    sigma, gradient = dexterity(tip_jacobian(robot, q, name), normal, own, LENGTH)
    assert gradient is not None
    assert sigma > 1e-5  # where the finite differences are good
    for column in range(robot.nv):
        step = np.eye(robot.nv)[column]

        def along(time: float, step: Array = step) -> Array:
            jacobian = tip_jacobian(robot, q + time * step, name)
            return np.array(smallest_of_five_rows(jacobian, normal, own))

        assert gradient[column] == pytest.approx(differences(along)[0], abs=1e-7)


@EVERY_FINGER
def test_axes_do_not_matter(grip: Any, name: str) -> None:
    normal, own = direction(grip), grip.robot.fingers[name].columns
    jacobian = tip_jacobian(grip.robot, grip.q, name)
    turn = pin.exp3(grip.rng.normal(size=3))
    turned = np.concatenate((turn @ jacobian[:3], turn @ jacobian[3:]))
    here = dexterity(jacobian, normal, own, LENGTH)
    there = dexterity(turned, turn @ normal, own, LENGTH)
    assert there[0] == pytest.approx(here[0], rel=1e-9)
    np.testing.assert_allclose(there[1], here[1], atol=1e-9)


def test_no_gradient_where_none_is_wanted(grip: Any) -> None:
    jacobian, normal = tip_jacobian(grip.robot, grip.q, "thumb"), direction(grip)
    own = grip.robot.fingers["thumb"].columns
    sigma, gradient = dexterity(jacobian, normal, own, LENGTH)
    assert gradient is not None
    assert dexterity(jacobian, normal, own, LENGTH, below=0.9 * sigma) == (sigma, None)
    _, wanted = dexterity(jacobian, normal, own, LENGTH, below=1.1 * sigma)
    np.testing.assert_array_equal(wanted, gradient)


def test_a_singular_finger_has_distance_zero_and_a_finite_gradient(grip: Any) -> None:
    jacobian, own = tip_jacobian(grip.robot, grip.q, "index"), grip.robot.fingers["index"].columns
    jacobian[:, own[1]] = jacobian[:, own[2]]  # two joints that do the same
    sigma, gradient = dexterity(jacobian, direction(grip), own, LENGTH)
    assert sigma < 1e-8
    assert np.isfinite(gradient).all()
