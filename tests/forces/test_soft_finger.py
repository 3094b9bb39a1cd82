"""Soft fingers: the wrench is applied, the ellipsoid kept, the limits are those of mechanics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.contacts import grasp_map
from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.forces.soft_finger import SoftFingerForces, SoftFingerProblem, allocate_soft

WEIGHT_N = 1.0
MU, TORSION_M = 0.6, 2e-3
SAMPLES = 40


def pinch(offset: float, torsion: float = TORSION_M, rate: float = 50.0) -> SoftFingerProblem:
    """Two fingers press along y; the mass centre is ``offset`` [m] from the line through them.

    The load comes on evenly, from none while they press with 2 N.
    """
    lever = np.array([[offset, -0.01, 0.0], [offset, 0.01, 0.0]])
    normals = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    return SoftFingerProblem(
        names=("one", "other"),
        lever=np.tile(lever, (SAMPLES, 1, 1)),
        normals=np.tile(normals, (SAMPLES, 1, 1)),
        friction=np.full(2, MU),
        torsion=np.full(2, torsion),
        normal_min=np.full(2, 0.1),
        normal_max=np.full(2, 5.0),
        wrench=share * [0.0, 0.0, WEIGHT_N, 0.0, 0.0, 0.0],
        start=2.0 * normals,
        force_rate_max=rate,
        step_s=0.01,
    )


def spin_load(problem: SoftFingerProblem, found: SoftFingerForces) -> np.ndarray:
    """(T, m) share of the ellipsoid's radius that is used."""
    normal = np.sum(found.force * problem.normals, axis=-1)
    across = np.linalg.norm(found.force - normal[..., None] * problem.normals, axis=-1)
    share = across / (problem.friction * normal)
    return np.hypot(share, found.moment / (problem.torsion * normal))


def test_forces_and_moments_apply_the_wrench_inside_the_ellipsoid() -> None:
    problem = pinch(offset=0.003)
    found = allocate_soft(problem)
    wrench = (grasp_map(problem.lever) @ found.force.reshape(SAMPLES, 6, 1))[..., 0]
    wrench[:, 3:] += np.einsum("tm,tmi->ti", found.moment, problem.normals)
    np.testing.assert_allclose(wrench, problem.wrench, atol=1e-8)
    assert spin_load(problem, found).max() <= 1.0 + 1e-8
    np.testing.assert_allclose(found.force[0], problem.start, atol=1e-9)
    np.testing.assert_allclose(found.moment[0], 0.0, atol=1e-12)
    change = np.linalg.norm(np.diff(found.force, axis=0), axis=-1)
    assert change.max() <= problem.force_rate_max * problem.step_s + 1e-8


def test_only_torsion_bears_the_moment_about_the_line() -> None:
    found = allocate_soft(pinch(offset=0.003))
    about_line = np.abs(found.moment[-1] @ [1.0, -1.0])
    assert about_line == pytest.approx(0.003 * WEIGHT_N, abs=1e-9)
    with pytest.raises(InfeasibleError, match="no forces of the fingers"):
        allocate_soft(pinch(offset=0.003, torsion=0.0))


def test_without_an_offset_point_contacts_do() -> None:
    found = allocate_soft(pinch(offset=0.0, torsion=0.0))
    np.testing.assert_allclose(found.moment, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.force[-1].sum(axis=0), [0.0, 0.0, WEIGHT_N], atol=1e-8)


def test_the_largest_offset_is_the_one_the_ellipsoid_allows() -> None:
    """Each finger bears half of weight and moment: (W / 2 mu n)^2 + (W d / 2 e n)^2 = 1."""
    normal = 5.0
    tangential = WEIGHT_N / (2.0 * MU * normal)
    largest = 2.0 * TORSION_M * normal / WEIGHT_N * np.sqrt(1.0 - tangential**2)
    allocate_soft(pinch(offset=0.99 * largest))
    with pytest.raises(InfeasibleError):
        allocate_soft(pinch(offset=1.01 * largest))


def test_more_torsion_is_never_worse() -> None:
    tight, wide = pinch(0.002, TORSION_M), pinch(0.002, 2.0 * TORSION_M)
    loads = [spin_load(each, allocate_soft(each))[-1].max() for each in (tight, wide)]
    assert loads[1] < loads[0]


@pytest.mark.parametrize(
    "change",
    [
        {"torsion": np.array([-1e-3, 1e-3])},
        {"friction": np.zeros(2)},
        {"wrench": np.full((SAMPLES, 6), np.nan)},
        {"start": np.zeros((3, 3))},
    ],
)
def test_numbers_that_cannot_be_are_refused(change: dict[str, np.ndarray]) -> None:
    with pytest.raises(InputError):
        replace(pinch(0.0), **change)
