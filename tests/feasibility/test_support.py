"""The closed form of the support function against forces, linear programs and rays."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.contacts import contact_frame, grasp_map
from pivotgait.exceptions import InputError
from pivotgait.feasibility import RayShooter, holding_power, static_verdicts, support
from pivotgait.forces import LinearRows
from tests.feasibility.cases import one, random_grasps

GRASPS = random_grasps(np.random.default_rng(0), 30, 4)


def _random_forces(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, B, m, 3) forces within cones and bounds, many on their edges."""
    problem = GRASPS.problem
    share = rng.choice([0.0, 0.3, 1.0], size=(count, *GRASPS.friction.shape))
    normal = problem.normal_min + share * (problem.normal_max - problem.normal_min)
    radius = GRASPS.friction * normal * np.sqrt(rng.uniform(0.0, 1.0, normal.shape))
    angle = rng.uniform(0.0, 2.0 * np.pi, normal.shape)
    local = np.stack((radius * np.cos(angle), radius * np.sin(angle), normal), axis=-1)
    return (contact_frame(problem.normals) @ local[..., None])[..., 0]


def test_no_forces_do_more_and_some_do_nearly_as_much():
    rng = np.random.default_rng(1)
    twist = rng.normal(size=(30, 6)) * [1, 1, 1, 10, 10, 10]
    most = support(GRASPS, twist)
    force = _random_forces(rng, 4000)
    wrench = (grasp_map(GRASPS.problem.lever) @ force.reshape(4000, 30, 12, 1))[..., 0]
    power = np.einsum("cbi,bi->cb", wrench, twist)
    assert np.all(power <= most + 1e-9)
    spread = most - power.min(axis=0)
    assert np.all(most - power.max(axis=0) < 0.35 * spread)


def test_it_is_sublinear():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, 30, 50, 6))
    both = support(GRASPS, a + b)
    assert np.all(both <= support(GRASPS, a) + support(GRASPS, b) + 1e-9)
    assert np.allclose(support(GRASPS, 3.0 * a), 3.0 * support(GRASPS, a))


def test_a_ray_ends_where_its_twist_supports_the_set():
    held = np.nonzero(static_verdicts(GRASPS).feasible)[0]
    for k in held[:6]:
        grasp = one(GRASPS, int(k))
        shooter = RayShooter(grasp)
        assert shooter.inside
        rays = shooter.shoot(
            np.random.default_rng(3).normal(size=(40, 6)) * [1, 1, 1, 0.1, 0.1, 0.1]
        )
        assert np.allclose(np.sum(rays.twist * rays.direction, axis=1), 1.0, atol=1e-6)
        # the closed form knows nothing of the solver
        assert np.allclose(holding_power(grasp, rays.twist[None])[0], rays.reach, rtol=1e-6)
        ends = grasp.problem.wrench + rays.reach[:, None] * rays.direction
        many = grasp.take(np.zeros(40, dtype=int))
        inside = grasp.problem.wrench + 0.999 * (ends - grasp.problem.wrench)
        outside = grasp.problem.wrench + 1.001 * (ends - grasp.problem.wrench)
        assert static_verdicts(many.changed(wrench=inside)).feasible.all()
        assert not static_verdicts(many.changed(wrench=outside)).feasible.any()


def test_without_an_upper_bound_the_support_may_have_no_end():
    open_ = GRASPS.changed(
        normal_max=np.where(np.arange(4) == 0, np.inf, GRASPS.problem.normal_max)
    )
    up = np.tile([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (30, 1))
    assert np.all(np.isinf(support(open_, up)))
    assert np.all(np.isfinite(support(open_, -up)))


def test_rows_and_batches_are_refused():
    rows = LinearRows(np.zeros((30, 1, 12)), np.zeros((30, 1)), np.ones((30, 1)))
    with pytest.raises(InputError, match="rows couple"):
        support(GRASPS.changed(rows=rows), np.ones((30, 6)))
    with pytest.raises(InputError, match="one at a time"):
        RayShooter(GRASPS)
    lost = int(np.argmin(static_verdicts(GRASPS).feasible))
    with pytest.raises(InputError, match="not inside"):
        RayShooter(one(GRASPS, lost)).shoot(np.eye(6))
