"""Volume of the set of wrenches that a grasp can apply: exact cones, sampled rays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from pivotgait.contacts import grasp_map
from pivotgait.exceptions import InputError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.rays import RayShooter
from pivotgait.frozen import Array

UNIT_BALL = pi**3 / 6.0
"""Volume of the unit ball in six dimensions."""


@dataclass(frozen=True)
class WrenchVolume:
    """Volume of the wrench set.

    Attributes:
        volume_N6: with moments divided by ``length_m`` [N^6].
        standard_error_N6: of the estimate.
        length_m: [m].
    """

    volume_N6: float
    standard_error_N6: float
    length_m: float


def wrench_volume(
    grasps: Grasps, length_m: float, rng: np.random.Generator, *, rays: int = 2000
) -> WrenchVolume:
    """Volume of all wrenches that the contacts of one grasp apply within their limits.

    In spherical coordinates about an inner point the volume is |ball| E[reach^6] over uniform
    directions. Directions are drawn in coordinates in which the set is nearly round: the sum of
    the contacts' covariances, each uniform in its truncated cone. Opposite rays are paired.

    Args:
        grasps: one grasp, whose contacts all have upper bounds.
        length_m: by which moments are divided [m].
        rng: of the directions.
        rays: their number.

    Raises:
        InputError: a contact without an upper bound: the volume is infinite.
    """
    problem = grasps.problem
    if not np.all(np.isfinite(problem.normal_max)):
        raise InputError("a contact has no upper bound", mend="give a finite normal_max")
    centre, covariance = _moments(grasps)
    values, axes = np.linalg.eigh(covariance)
    if values[0] <= 1e-12 * values[-1]:
        return WrenchVolume(0.0, 0.0, length_m)
    shooter = RayShooter(Grasps(replace(problem, wrench=centre[None]), grasps.friction))
    if not shooter.inside:  # rows may cut the middle of the cones off
        shooter = RayShooter(grasps)
    if not shooter.inside:
        return WrenchVolume(0.0, 0.0, length_m)
    shape = axes * np.sqrt(values)
    way = rng.normal(size=(rays // 2, 6))
    way /= np.linalg.norm(way, axis=1)[:, None]
    reach = shooter.shoot(np.concatenate((way, -way)) @ shape.T).reach
    pairs = (reach**6).reshape(2, -1).mean(axis=0)
    scale = UNIT_BALL * float(np.sqrt(np.prod(values))) / length_m**3
    error = float(np.std(pairs, ddof=1) / np.sqrt(len(pairs)))
    return WrenchVolume(scale * float(pairs.mean()), scale * error, length_m)


def _moments(grasps: Grasps) -> tuple[Array, Array]:
    """Mean (6,) and covariance (6, 6) of the wrench of forces uniform in their truncated cones."""
    problem, mu = grasps.problem, grasps.friction[0]
    ends = np.stack((problem.normal_min[0], problem.normal_max[0]))
    ramp = problem.fixed[0]
    low, high = np.where(np.isnan(ramp), ends, ramp)
    first, second = _power_mean(low, high, 1), _power_mean(low, high, 2)
    normal = problem.normals[0]
    along = normal[:, :, None] * normal[:, None, :]
    # a disc of radius mu f_n has the variance (mu f_n)^2 / 4 along each tangent
    spread = (second - first**2)[:, None, None] * along
    spread = spread + (0.25 * mu**2 * second)[:, None, None] * (np.eye(3) - along)
    maps = np.moveaxis(grasp_map(problem.lever[0]).reshape(6, -1, 3), 1, 0)
    covariance = np.einsum("mij,mjk,mlk->il", maps, spread, maps)
    return np.einsum("mij,mj->i", maps, first[:, None] * normal), covariance


def _power_mean(low: Array, high: Array, power: int) -> Array:
    """Mean of f_n^power where f_n has the density f_n^2 of a cone's slices."""
    apart = high - low > 1e-9 * np.maximum(high, 1.0)
    wide = np.where(apart, high, low + 1.0)
    mean = 3.0 * (wide ** (3 + power) - low ** (3 + power))
    mean = mean / ((3 + power) * (wide**3 - low**3))
    return np.where(apart, mean, low**power)
