"""Residuals of postures: every kind's gradient is exact, and the model is a Gauss-Newton one."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array
from pivotgait.planning.key_posture import KeyPose, held_on
from pivotgait.planning.posture_residuals import PostureResiduals, PostureWeights
from tests.planning import knife_keys
from tests.planning.knife_keys import anywhere, keys, robot, world

KINDS = {
    "position": {},
    "direction": {},
    "pad": {},
    "clearance": {},
    "limit": {"limit_margin": 0.2},
    "coupling": {},
    "dexterity": {"dexterity_wish": 0.02},
    "home": {},
    "change": {},
}
STENCIL = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


def only(kind: str) -> PostureWeights:
    """Weights under which no other residual counts."""
    nothing = dict.fromkeys(KINDS.keys() - {kind}, 1e15)
    return PostureWeights(**nothing, **KINDS[kind])


def slope(residuals: PostureResiduals, q: Array, along: Array, step: float) -> float:
    """Half the cost's derivative along a direction, by differences of fourth order."""
    costs = [residuals.normal_equations(q + k * step * along).cost for k in (-2, -1, 1, 2)]
    return float(STENCIL @ costs) / (2.0 * step)


def directions(rng: np.random.Generator, count: int) -> Array:
    found = rng.normal(size=(count, len(keys()), robot().nv))
    return found / np.linalg.norm(found, axis=(1, 2), keepdims=True)


def test_every_kind_of_residual_is_listed() -> None:
    margins = {"clearance_wish", "idle_wish", "limit_margin", "coupling_margin", "dexterity_wish"}
    assert {field.name for field in fields(PostureWeights)} == KINDS.keys() | margins


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_gradient_of_each_kind_alone(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = anywhere(rng, len(keys()))
    residuals = PostureResiduals(
        robot(), keys(), world() if kind == "clearance" else None, only(kind)
    )
    model = residuals.normal_equations(q)
    assert model.cost > 0.0
    size = float(np.linalg.norm(model.gradient))
    # distances of Coal are good to 1e-7 m or worse: a larger step, a looser limit
    step, close = (1e-4, 1e-3) if kind == "clearance" else (1e-4, 1e-7)
    for along in directions(rng, 3):
        wanted = float(model.gradient @ along.ravel())
        assert slope(residuals, q, along, step) == pytest.approx(wanted, abs=close * size)


@pytest.mark.parametrize("collisions", [False, True])
@pytest.mark.parametrize("seed", [1, 4])
def test_gradient_is_half_the_cost_s(collisions: bool, seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = robot().home + 0.2 * rng.normal(size=(len(keys()), robot().nv))
    residuals = PostureResiduals(robot(), keys(), world() if collisions else None)
    model = residuals.normal_equations(q)
    size, close = float(np.linalg.norm(model.gradient)), 1e-4 if collisions else 1e-8
    for along in directions(rng, 4):
        wanted = float(model.gradient @ along.ravel())
        assert slope(residuals, q, along, 1e-4) == pytest.approx(wanted, abs=close * size)


@pytest.mark.parametrize("collisions", [False, True])
@pytest.mark.parametrize("kind", ["all", *KINDS])
def test_normal_matrix_is_that_of_a_jacobian(kind: str, collisions: bool) -> None:
    """Symmetric, positive semidefinite, its range holds the gradient, neighbours only."""
    n, count = robot().nv, len(keys())
    weights = None if kind == "all" else only(kind)
    residuals = PostureResiduals(robot(), keys(), world() if collisions else None, weights)
    model = residuals.normal_equations(anywhere(np.random.default_rng(3), count))
    size = np.abs(model.normal).max()
    np.testing.assert_allclose(model.normal, model.normal.T, atol=1e-12 * size)
    values, vectors = np.linalg.eigh(model.normal)
    assert values.min() > -1e-12 * values.max()
    kept = values > 1e-9 * values.max()
    inside = vectors[:, kept].T @ model.gradient
    # g = J^T r lies in the range of J^T J, and r^T r is no less than r's part in the range of J
    off = model.gradient - vectors[:, kept] @ inside
    assert np.linalg.norm(off) < 1e-3 * np.linalg.norm(model.gradient)
    assert inside**2 @ (1.0 / values[kept]) <= model.cost * (1.0 + 1e-6)
    blocks = model.normal.reshape(count, n, count, n)
    for k in range(count):
        for other in range(count):
            assert abs(k - other) <= 1 or not blocks[k, :, other].any()


@pytest.mark.parametrize("kind", ["home", "change", "position", "direction"])
def test_nothing_to_ask_for_costs_nothing(kind: str) -> None:
    """Two postures at home, the tool far away and untouched."""
    far = [KeyPose("far away", np.eye(3), np.array([9.0, 9.0, 9.0]), {})] * 2
    residuals = PostureResiduals(robot(), far, weights=only(kind))
    assert residuals.normal_equations(np.tile(robot().home, (2, 1))).cost < 1e-20


def test_contacts_that_last() -> None:
    lasting = held_on(keys())
    assert {("thumb", 0, 1), ("index", 1, 2), ("index", 2, 3), ("thumb", 2, 3)} <= set(lasting)
    assert not any(finger == "middle" for finger, *_ in lasting)
    moved = knife_keys.scene().contacts["index_edge_near"]
    elsewhere = KeyPose("elsewhere", np.eye(3), np.zeros(3), {"index": moved})
    assert held_on([keys()[0], elsewhere]) == ()


def test_a_finger_the_robot_does_not_have() -> None:
    contact = knife_keys.scene().contacts["index_edge"]
    key = KeyPose("lifted", np.eye(3), np.zeros(3), {"ring": contact})
    with pytest.raises(UnknownNameError, match=r"^lifted: unknown finger 'ring'.*known: "):
        PostureResiduals(robot(), [key])


@pytest.mark.parametrize(
    ("rotation", "position"), [(np.full((3, 3), np.nan), np.zeros(3)), (np.eye(3), [0, np.inf, 0])]
)
def test_a_pose_that_is_not_finite(rotation: Array, position: Array) -> None:
    with pytest.raises(InputError, match=r"^start: the tool's pose is not finite"):
        KeyPose("start", rotation, np.array(position, dtype=float), {})
