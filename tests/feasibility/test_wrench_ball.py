"""The ball of external wrenches and the volume, against independent ways to find them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.feasibility import (
    Grasps,
    RayShooter,
    holding_power,
    static_verdicts,
    tool_length,
    wrench_ball,
    wrench_volume,
)
from pivotgait.feasibility.wrench_volume import UNIT_BALL
from pivotgait.forces import LinearRows
from tests.feasibility.cases import PIVOT_IN_TOOL, one, random_grasps

LENGTH = tool_length(PIVOT_IN_TOOL)
METRIC = np.array([1.0, 1.0, 1.0, LENGTH, LENGTH, LENGTH])


def held(contacts: int, count: int, *, seed: int = 0) -> list[Grasps]:
    grasps = random_grasps(np.random.default_rng(seed), 60, contacts)
    deep = static_verdicts(grasps, exact=True).depth
    return [one(grasps, int(k)) for k in np.argsort(-deep)[:count]]


def sampled_radius(grasp: Grasps, rng: np.random.Generator) -> float:
    """Least holding power over unit directions, sampled anew about the best ones each round.

    Only the closed form of the support function: no solver, no rays.
    """
    ways, least = rng.normal(size=(20_000, 6)), np.inf
    for _ in range(60):
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        power = holding_power(grasp, (ways / METRIC)[None])[0]
        least = min(least, float(power.min()))
        best = ways[np.argsort(power)[:150]]
        # steps like the differences of good directions follow narrow valleys
        one, other = best[rng.integers(150, size=(2, 4000))]
        ways = best[rng.integers(150, size=4000)] + rng.normal(size=(4000, 1)) * (one - other)
        ways += 1e-4 * rng.normal(size=ways.shape)
        ways = np.concatenate((best, ways))
    return least


@pytest.mark.parametrize(
    "contacts", [3, *(pytest.param(each, marks=pytest.mark.slow) for each in (4, 5))]
)
def test_the_radius_agrees_with_sampled_directions_to_one_percent(contacts):
    for k, grasp in enumerate(held(contacts, 5)):
        ball = wrench_ball(grasp, LENGTH)
        assert ball.radius_N > 0.0
        assert ball.at_least_N >= 0.99 * ball.radius_N
        sampled = sampled_radius(grasp, np.random.default_rng(k))
        assert sampled == pytest.approx(ball.radius_N, rel=0.01)
        assert sampled >= ball.at_least_N


def test_within_the_ball_everything_is_resisted_and_its_direction_is_the_weakest():
    rng = np.random.default_rng(3)
    for grasp in held(4, 4):
        ball = wrench_ball(grasp, LENGTH)
        ways = rng.normal(size=(2000, 6))
        ways *= ball.at_least_N / np.linalg.norm(ways, axis=1, keepdims=True)
        # an external wrench is what the contacts must apply less
        loads = grasp.problem.wrench - 0.999 * ways * METRIC
        many = grasp.take(np.zeros(2000, dtype=int))
        assert static_verdicts(many.changed(wrench=loads)).feasible.all()
        for share, good in ((0.995, True), (1.005, False)):
            load = grasp.problem.wrench - share * ball.direction
            assert static_verdicts(grasp.changed(wrench=load)).feasible[0] == good


def test_turning_everything_keeps_ball_and_volume():
    grasp = held(4, 1)[0]
    turn = Rotation.random(rng=np.random.default_rng(1)).as_matrix()
    problem = grasp.problem
    wrench = np.concatenate((problem.wrench[:, :3] @ turn.T, problem.wrench[:, 3:] @ turn.T), 1)
    turned = grasp.changed(
        lever=problem.lever @ turn.T, normals=problem.normals @ turn.T, wrench=wrench
    )
    before, after = wrench_ball(grasp, LENGTH), wrench_ball(turned, LENGTH)
    assert after.radius_N == pytest.approx(before.radius_N, rel=5e-3)
    sizes = [wrench_volume(each, LENGTH, np.random.default_rng(0)) for each in (grasp, turned)]
    error = np.hypot(*(size.standard_error_N6 for size in sizes))
    assert abs(sizes[0].volume_N6 - sizes[1].volume_N6) < 4.0 * error


def test_weaker_joints_make_it_smaller():
    grasp = held(4, 1)[0]
    push = np.zeros((1, 3, 12))
    push[0, :, 3:] = np.kron(np.eye(3), [1.0, 1.0, 1.0])
    radii = []
    for limit in (50.0, 2.0, 1.5):
        rows = LinearRows(push, np.full((1, 3), -limit), np.full((1, 3), limit))
        radii.append(wrench_ball(grasp.changed(rows=rows), LENGTH).radius_N)
    assert radii[0] == pytest.approx(wrench_ball(grasp, LENGTH).radius_N, rel=5e-3)
    assert radii[0] >= radii[1] >= radii[2]
    assert radii[2] < radii[0]


def test_a_grasp_that_holds_nothing_resists_nothing():
    grasps = random_grasps(np.random.default_rng(4), 40, 4)
    lost = one(grasps, int(np.argmin(static_verdicts(grasps).feasible)))
    assert wrench_ball(lost, LENGTH).radius_N == 0.0
    two = one(random_grasps(np.random.default_rng(4), 2, 2), 0)
    assert wrench_ball(two, LENGTH).radius_N == 0.0
    assert not RayShooter(two).inside
    assert wrench_volume(two, LENGTH, np.random.default_rng(0)).volume_N6 == 0.0


def test_the_volume_agrees_with_points_thrown_into_a_box():
    grasp = held(3, 1)[0]
    found = wrench_volume(grasp, LENGTH, np.random.default_rng(0), rays=6000)
    # a box in the axes of the set's spread, its sides by the support function
    force = _forces(grasp, np.random.default_rng(1), 4000)
    _, _, axes = np.linalg.svd(force - force.mean(axis=0), full_matrices=False)
    top = holding_power(grasp, (axes / METRIC)[None])[0]
    bottom = holding_power(grasp, (-axes / METRIC)[None])[0]
    rng = np.random.default_rng(2)
    points = (rng.uniform(0.0, 1.0, (20_000, 6)) * (top + bottom) - bottom) @ axes * METRIC
    many = grasp.take(np.zeros(20_000, dtype=int))
    share = static_verdicts(many.changed(wrench=grasp.problem.wrench + points)).feasible.mean()
    box = float(np.prod(top + bottom))
    error = box * np.sqrt(share * (1.0 - share) / 20_000)
    assert share > 0.01
    assert abs(found.volume_N6 - share * box) < 4.0 * np.hypot(error, found.standard_error_N6)


def _forces(grasp: Grasps, rng: np.random.Generator, count: int) -> np.ndarray:
    """Wrenches (count, 6) of random forces, moments over the length."""
    from pivotgait.contacts import grasp_map

    problem, mu = grasp.problem, grasp.friction[0]
    normal = rng.uniform(problem.normal_min[0], problem.normal_max[0], (count, len(mu)))
    side = rng.normal(size=(count, len(mu), 3))
    side -= np.sum(side * problem.normals[0], axis=-1, keepdims=True) * problem.normals[0]
    side *= (mu * normal * rng.uniform(0, 1, normal.shape))[..., None] / np.linalg.norm(
        side, axis=-1, keepdims=True
    )
    force = normal[..., None] * problem.normals[0] + side
    return (grasp_map(problem.lever[0]) @ force.reshape(count, -1, 1))[..., 0] / METRIC


def test_the_volume_grows_with_the_sixth_power_of_force():
    grasp = held(4, 1)[0]
    bare = grasp.changed(normal_min=np.zeros((1, 4)))
    twice = bare.changed(normal_max=2.0 * bare.problem.normal_max)
    sizes = [wrench_volume(each, LENGTH, np.random.default_rng(0)) for each in (bare, twice)]
    assert sizes[1].volume_N6 == pytest.approx(64.0 * sizes[0].volume_N6, rel=1e-6)
    longer = wrench_volume(bare, 2.0 * LENGTH, np.random.default_rng(0))
    assert longer.volume_N6 == pytest.approx(sizes[0].volume_N6 / 8.0, rel=1e-6)
    assert pytest.approx(5.16771278) == UNIT_BALL


def test_an_endless_volume_is_refused():
    grasp = held(3, 1)[0]
    high = np.where(np.arange(3) == 0, np.inf, grasp.problem.normal_max)
    with pytest.raises(InputError, match="no upper bound"):
        wrench_volume(grasp.changed(normal_max=high), LENGTH, np.random.default_rng(0))
    assert wrench_ball(grasp.changed(normal_max=high), LENGTH).radius_N > 0.0
