"""A verdict is right, comes with its proof, and does not depend on the batch it is made in."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.feasibility import Grasps, held_at, static_verdicts
from pivotgait.feasibility.static_verdicts import CHUNK
from pivotgait.forces import LinearRows, allocate
from pivotgait.models import load_scene
from tests.feasibility.cases import pyramid_verdict, random_grasps

FACETS = 48


def _agreement(count: int) -> tuple[int, int, int]:
    """Grasps both pyramids call feasible, both infeasible, and between the two; checks the rest."""
    inside = outside = between = 0
    for contacts in (3, 4, 5):
        grasps = random_grasps(np.random.default_rng(contacts), -(-count // 3), contacts)
        verdicts = static_verdicts(grasps)
        for k in range(grasps.count):
            inner = pyramid_verdict(grasps, k, FACETS, outer=False)
            outer = pyramid_verdict(grasps, k, FACETS, outer=True)
            assert outer or not inner
            if inner != outer:
                between += 1
                continue
            assert verdicts.feasible[k] == inner, f"{contacts} contacts, grasp {k}"
            inside, outside = inside + inner, outside + (not inner)
    return inside, outside, between


def test_verdicts_agree_with_linear_programs_on_200_grasps():
    inside, outside, between = _agreement(200)
    sys.stdout.write(f"feasible {inside}, infeasible {outside}, between {between}\n")
    assert min(inside, outside) > 40
    assert between < 10


@pytest.mark.slow
def test_verdicts_agree_with_linear_programs_on_1000_grasps():
    inside, outside, between = _agreement(1000)
    sys.stdout.write(f"feasible {inside}, infeasible {outside}, between {between}\n")
    assert min(inside, outside) > 200
    assert between < 30


@pytest.mark.parametrize("contacts", [3, 4, 5])
@pytest.mark.parametrize("exact", [False, True])
def test_every_verdict_is_proven(contacts, exact):
    grasps = random_grasps(np.random.default_rng(1), 1500, contacts)
    found = static_verdicts(grasps, exact=exact)
    good = found.feasible
    assert 0.05 < good.mean() < 0.95
    problem = grasps.problem
    normal = np.sum(found.force * problem.normals, axis=-1)
    assert found.wrench_residual()[good].max() < 1e-9
    assert found.cone_margin()[good].min() > -1e-8
    assert np.all(normal[good] >= problem.normal_min[good] - 1e-8)
    assert np.all(normal[good] <= problem.normal_max[good] + 1e-8)
    # closed form, without any solver: along the twist no contact forces match the load
    assert found.proof()[~good].max() < -1e-9
    assert np.all(found.depth[good] > -1e-8)
    assert np.all(found.depth[~good] < 0.0)


def test_it_agrees_with_the_allocation_of_one_grasp_at_a_time():
    grasps = random_grasps(np.random.default_rng(2), 40, 4)
    found = static_verdicts(grasps).feasible
    for k in range(grasps.count):
        one = grasps.take(np.array([k]))
        assert allocate(one.problem, "clarabel").feasible[0] == found[k]


def test_neither_order_nor_batch_nor_chunk_matters():
    grasps = random_grasps(np.random.default_rng(3), 300, 4)
    whole = static_verdicts(grasps).feasible
    order = np.random.default_rng(4).permutation(300)
    assert np.array_equal(static_verdicts(grasps.take(order)).feasible, whole[order])
    many = grasps.take(np.arange(CHUNK + 200) % 300)
    assert np.array_equal(static_verdicts(many).feasible, np.resize(whole, CHUNK + 200))


def test_turning_everything_changes_nothing():
    grasps = random_grasps(np.random.default_rng(5), 100, 4)
    turn = Rotation.random(rng=np.random.default_rng(6)).as_matrix()
    problem = grasps.problem
    wrench = np.concatenate((problem.wrench[:, :3] @ turn.T, problem.wrench[:, 3:] @ turn.T), 1)
    turned = grasps.changed(
        lever=problem.lever @ turn.T, normals=problem.normals @ turn.T, wrench=wrench
    )
    before, after = static_verdicts(grasps, exact=True), static_verdicts(turned, exact=True)
    assert np.allclose(before.depth, after.depth, atol=1e-6)


def test_more_friction_and_wider_bounds_never_harm():
    grasps = random_grasps(np.random.default_rng(7), 400, 4)
    before = static_verdicts(grasps).feasible
    problem = grasps.problem
    for more in (
        grasps.changed(friction=1.3 * grasps.friction),
        grasps.changed(normal_max=1.3 * problem.normal_max),
        grasps.changed(normal_min=0.5 * problem.normal_min),
    ):
        after = static_verdicts(more).feasible
        assert np.all(after | ~before)
        assert after.sum() > before.sum()


def test_two_contacts_cannot_resist_a_moment_about_their_line():
    grasps = random_grasps(np.random.default_rng(8), 50, 2)
    found = static_verdicts(grasps)
    assert not found.feasible.any()
    assert np.all(np.isinf(found.depth))
    assert found.proof().max() < 0.0


def test_rows_bind():
    grasps = random_grasps(np.random.default_rng(9), 300, 4)
    free = static_verdicts(grasps)
    push = np.zeros((300, 1, 12))
    push[:, 0, 3:6] = grasps.problem.normals[:, 1]
    rows = LinearRows(push, np.full((300, 1), -np.inf), np.full((300, 1), 1.0))
    bound = static_verdicts(grasps.changed(rows=rows))
    same = static_verdicts(
        grasps.changed(
            normal_min=np.minimum(grasps.problem.normal_min, 1.0),
            normal_max=np.where(np.arange(4) == 1, 1.0, grasps.problem.normal_max),
        )
    )
    assert np.array_equal(bound.feasible, same.feasible)
    assert bound.feasible.sum() < free.feasible.sum()
    with pytest.raises(InputError, match="rows couple"):
        bound.proof()


def test_a_tool_at_rest_by_the_batch_is_the_scenes_one():
    scene = load_scene("knife")
    fingers = [scene.contacts[name] for name in ("thumb_spine", "index_edge")]
    rotation = scene.lift_rotation(scene.gaits["default"][0].to)
    both = Rotation.concatenate((rotation, rotation * Rotation.from_rotvec([0.3, 0.1, 0.0])))
    grasps = held_at(scene, fingers, both)
    lever = rotation.as_matrix() @ fingers[0].point
    assert np.allclose(grasps.problem.lever[0, 1], lever)
    assert np.allclose(grasps.problem.wrench[:, 2], scene.tool.mass * 9.81)
    usable = 1.0 - scene.allocation.friction_reserve
    assert grasps.friction[0, 1] == pytest.approx(usable * fingers[0].friction)
    assert static_verdicts(grasps).feasible[0]


def test_bad_input_is_refused():
    grasps = random_grasps(np.random.default_rng(0), 3, 3)
    with pytest.raises(InputError, match="friction has shape"):
        Grasps(grasps.problem, np.ones(3))
    with pytest.raises(InputError, match="not positive"):
        grasps.changed(friction=np.zeros((3, 3)))
