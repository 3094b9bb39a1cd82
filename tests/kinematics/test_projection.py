"""Projection closes the chain by the shortest steps; resolved velocities are optimal."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.linalg import lstsq

from pivotgait.exceptions import InputError, SingularCoordinatesError
from pivotgait.kinematics import ClosedChain, frame_coordinates, project, resolve
from pivotgait.kinematics.minimum_norm import minimum_norm, mobility
from pivotgait.models import Robot

Array = NDArray[np.float64]


def weights_for(robot: Robot) -> Array:
    return np.linspace(0.2, 5.0, robot.nv)


@pytest.mark.parametrize("fingers", [1, 2, 3])
@pytest.mark.parametrize("weighted", [False, True])
def test_projection_puts_tips_on_their_holds(grip: Any, fingers: int, weighted: bool) -> None:
    chain = ClosedChain(grip.robot, grip.holds[:fingers])
    weights = weights_for(grip.robot) if weighted else None
    found = project(chain, grip.near(), grip.oRtool, grip.position, weights=weights)
    assert found.converged
    assert found.residual_norm <= 1e-10
    assert found.iterations <= 6
    data = grip.robot.model.createData()
    pin.forwardKinematics(grip.robot.model, data, found.q)
    pin.updateFramePlacements(grip.robot.model, data)
    for hold in chain.holds:
        tip = data.oMf[hold.finger.tip_frame_id]
        centre = grip.position + grip.oRtool @ hold.centre
        np.testing.assert_allclose(tip.translation, centre, atol=1.1e-10)
        axis, normal = tip.rotation @ hold.axis_in_tip, grip.oRtool @ hold.normal
        np.testing.assert_allclose(axis, normal, atol=1.1e-10 / hold.finger.tip_radius)


def test_projection_is_idempotent(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    once = project(chain, grip.near(), grip.oRtool, grip.position)
    twice = project(chain, once.q, grip.oRtool, grip.position)
    assert twice.iterations == 0
    np.testing.assert_array_equal(once.q, twice.q)


def test_chain_is_left_at_the_answer(grip: Any) -> None:
    chain, other = (ClosedChain(grip.robot, grip.holds) for _ in range(2))
    found = project(chain, grip.near(), grip.oRtool, grip.position)
    other.update(found.q, grip.oRtool, grip.position)
    np.testing.assert_array_equal(chain.residual, other.residual)
    np.testing.assert_array_equal(chain.jacobian, other.jacobian)


def test_newton_converges_quadratically(grip: Any) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds), grip.near(0.02)
    norms = [
        project(
            chain, q, grip.oRtool, grip.position, max_iterations=k, tolerance=1e-14
        ).residual_norm
        for k in range(4)
    ]
    for before, after in pairwise(norms[1:]):
        # In units of the grip's own size, about 0.1 m.
        assert after < max((before / 0.01) ** 2, 1e-14)


@pytest.mark.parametrize("length", [None, 0.04])
def test_step_has_least_norm(grip: Any, length: float | None) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds[:2]), grip.near(0.02)
    weights = weights_for(grip.robot)
    one = project(
        chain,
        q,
        grip.oRtool,
        grip.position,
        weights=weights,
        max_iterations=1,
        angle_length=length,
    )
    chain.update(q, grip.oRtool, grip.position)
    expected = lstsq(chain.jacobian / np.sqrt(weights), -chain.residual)[0] / np.sqrt(weights)
    np.testing.assert_allclose(one.q - q, expected, atol=1e-11)


def test_long_steps_are_cut(grip: Any) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds), grip.near()
    one = project(chain, q, grip.oRtool, grip.position, max_iterations=1, max_step=1e-3)
    assert np.linalg.norm(one.q - q) == pytest.approx(1e-3)


@pytest.mark.parametrize("how", ["fixed", "infinite weight"])
def test_fixed_joints_stay(grip: Any, how: str) -> None:
    chain, q = ClosedChain(grip.robot, grip.holds[:2]), grip.near(0.01)
    still = [2, 4, 5]
    weights = np.ones(grip.robot.nv)
    weights[still] = np.inf
    options: dict[str, Any] = {"fixed": still} if how == "fixed" else {"weights": weights}
    found = project(chain, q, grip.oRtool, grip.position, **options)
    assert found.converged
    np.testing.assert_array_equal(found.q[still], q[still])


def test_unreachable_tool_ends_in_a_record(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    far = grip.position + np.array([3.0, 0.0, 0.0])
    found = project(chain, grip.q, grip.oRtool, far)
    assert not found.converged
    assert found.residual_norm > 0.5
    assert np.all(np.isfinite(found.q))


def test_joints_too_few_to_close_end_in_a_record(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    found = project(
        chain, grip.near(), grip.oRtool, grip.position, fixed=range(6), max_iterations=50
    )
    assert not found.converged
    assert np.all(np.isfinite(found.q))


def test_a_start_that_is_no_number_is_not_called_closed(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.holds)
    found = project(chain, grip.q * np.nan, grip.oRtool, grip.position)
    assert not found.converged


def test_singular_start_is_refused(grip: Any) -> None:
    chain = ClosedChain(grip.robot, grip.turned(0.5 * np.pi, 0.3))
    with pytest.raises(SingularCoordinatesError):
        project(chain, grip.q, grip.oRtool, grip.position)


def test_search_that_turns_singular_ends_in_a_record(
    grip: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a wide singular region, a long step towards a tool out of reach falls into it."""
    monkeypatch.setattr(frame_coordinates, "SMALLEST_COS_PSI", 0.95)
    chain = ClosedChain(grip.robot, grip.turned(0.2, 0.3))
    far = grip.position + np.array([1.0, 0.0, 0.0])
    found = project(chain, grip.q, grip.oRtool, far, max_step=10.0)
    assert not found.converged
    assert found.iterations < 20
    assert np.linalg.norm(chain.residual * chain.row_lengths()) == found.residual_norm
    left = [joint.translation.copy() for joint in chain.data.oMi]
    chain.update(found.q, grip.oRtool, far)
    np.testing.assert_array_equal(left, [joint.translation for joint in chain.data.oMi])


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan])
def test_bad_weights_are_refused(grip: Any, weight: float) -> None:
    chain, weights = ClosedChain(grip.robot, grip.holds), np.ones(grip.robot.nv)
    weights[3] = weight
    with pytest.raises(InputError, match="weights"):
        project(chain, grip.q, grip.oRtool, grip.position, weights=weights)
    with pytest.raises(InputError, match="weights"):
        resolve(chain, np.zeros(15), np.zeros(grip.robot.nv), weights=weights[:5])


def open_chain(grip: Any, fingers: int) -> tuple[ClosedChain, Array, Array]:
    chain = ClosedChain(grip.robot, grip.holds[:fingers])
    chain.update(grip.near(), grip.oRtool, grip.position)
    return chain, grip.rng.normal(size=chain.rows), grip.rng.normal(size=grip.robot.nv)


@pytest.mark.parametrize("fingers", [1, 2, 3])
def test_resolved_velocities_are_optimal(grip: Any, fingers: int) -> None:
    chain, b, wanted = open_chain(grip, fingers)
    weights = weights_for(grip.robot)
    v = resolve(chain, b, wanted, weights=weights)
    np.testing.assert_allclose(chain.jacobian @ v, b, atol=1e-11)
    # Stationary: W (v - wanted) = A^T multipliers.
    gradient = weights * (v - wanted)
    multipliers = np.linalg.lstsq(chain.jacobian.T, gradient, rcond=None)[0]
    np.testing.assert_allclose(
        chain.jacobian.T @ multipliers, gradient, atol=1e-10 * np.linalg.norm(gradient)
    )


def test_resolved_velocities_are_those_of_the_pseudo_inverse(grip: Any) -> None:
    chain, b, wanted = open_chain(grip, 2)
    inverse = np.linalg.pinv(chain.jacobian)
    expected = inverse @ b + wanted - inverse @ (chain.jacobian @ wanted)
    np.testing.assert_allclose(
        resolve(chain, b, wanted), expected, atol=1e-12 * np.linalg.norm(expected)
    )


def test_wanted_velocities_that_keep_the_chain_closed_are_kept(grip: Any) -> None:
    chain, b, wanted = open_chain(grip, 3)
    kept = resolve(chain, b, wanted)
    np.testing.assert_allclose(resolve(chain, b, kept), kept, atol=1e-11)


def test_fixed_joints_keep_their_wanted_velocity(grip: Any) -> None:
    chain, b, wanted = open_chain(grip, 2)
    v = resolve(chain, b, wanted, fixed=[0, 7])
    np.testing.assert_array_equal(v[[0, 7]], wanted[[0, 7]])
    np.testing.assert_allclose(chain.jacobian @ v, b, atol=1e-10)


def test_repeated_hold_is_resolved_like_one(grip: Any) -> None:
    one, twice = (ClosedChain(grip.robot, [grip.holds[0]] * n) for n in (1, 2))
    q, wanted = grip.near(), grip.rng.normal(size=grip.robot.nv)
    for chain in (one, twice):
        chain.update(q, grip.oRtool, grip.position)
    b = grip.rng.normal(size=5)
    np.testing.assert_allclose(
        resolve(twice, np.tile(b, 2), wanted), resolve(one, b, wanted), atol=1e-10
    )


@pytest.mark.parametrize(("rows", "rank"), [(4, 4), (4, 2), (7, 7), (9, 7), (9, 3), (0, 0)])
def test_minimum_norm_is_the_pseudo_inverse(rows: int, rank: int) -> None:
    rng = np.random.default_rng(rows + 10 * rank)
    matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, 7))
    right = rng.normal(size=rows)
    found = minimum_norm(matrix, right, mobility(None, (), 7))
    np.testing.assert_allclose(found, np.linalg.pinv(matrix, rcond=1e-10) @ right, atol=1e-11)
