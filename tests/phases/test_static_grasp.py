"""The smallest turn after which the staying fingers hold the tool, against brute force."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.forces import AllocationProblem, allocate
from pivotgait.phases.removal_problem import RemovalProblem
from pivotgait.phases.static_grasp import StaticTurn, smallest_turn

Array = NDArray[np.float64]
Fixture = Callable[..., Any]
TURNING = pytest.mark.parametrize(("name", "place"), [("knife", 2), ("screwdriver", 2)])
HOLDING = pytest.mark.parametrize(("name", "place"), [("screwdriver", 4), ("table_knife", 2)])


def holds(problem: RemovalProblem, orientations: Rotation) -> NDArray[np.bool_]:
    """Whether pivot and staying fingers hold the tool at rest, by force allocation alone."""
    n, body = problem.staying, problem.body
    turn = orientations.as_matrix()
    samples = len(turn)
    points = np.vstack((body.pivot_in_tool, problem.points[:n]))
    normals = np.empty((samples, n + 1, 3))
    normals[:, 0] = (0.0, 0.0, 1.0)
    normals[:, 1:] = np.einsum("sij,mj->smi", turn, problem.frames[:n, :, 2])
    wrench = np.zeros((samples, 6))
    wrench[:, :3] = -body.mass * body.gravity
    names = ("pivot", *(f"finger{i}" for i in range(n)))
    return allocate(
        AllocationProblem(
            names=names,
            lever=np.einsum("sij,mj->smi", turn, points),
            normals=normals,
            friction=problem.friction[: n + 1],
            normal_min=np.tile(problem.normal_min[: n + 1], (samples, 1)),
            normal_max=np.tile(problem.normal_max[: n + 1], (samples, 1)),
            wrench=wrench,
            objective="effort",
        ),
        "interior_point",
    ).feasible


def turned(problem: RemovalProblem, axis: Array, angle: float) -> Rotation:
    return Rotation.from_quat(problem.orientation) * Rotation.from_rotvec(angle * axis)


def directions(count: int) -> Array:
    """Unit vectors spread evenly over the sphere (a Fibonacci spiral)."""
    place = np.arange(count) + 0.5
    z, around = 1.0 - 2.0 * place / count, np.pi * (1.0 + np.sqrt(5.0)) * place
    flat = np.sqrt(1.0 - z**2)
    return np.stack((flat * np.cos(around), flat * np.sin(around), z), axis=-1)


@HOLDING
def test_no_turn_is_needed_where_the_fingers_hold_already(
    moment: Fixture, name: str, place: int
) -> None:
    problem = moment(name, place).problem
    assert holds(problem, Rotation.from_quat(problem.orientation[None, :])).all()
    need = smallest_turn(problem)
    assert need.feasible
    assert need.angle < 1e-6  # the angle at which the search stops


@TURNING
def test_answer_is_a_static_grasp(moment: Fixture, name: str, place: int) -> None:
    problem = moment(name, place).problem
    need = smallest_turn(problem)
    assert need.feasible
    assert_static(problem, need)
    start = Rotation.from_quat(problem.orientation)
    turn = start.inv() * Rotation.from_quat(need.orientation)
    assert turn.magnitude() == pytest.approx(need.angle, abs=1e-9)
    assert not holds(problem, Rotation.concatenate([start])).any()


def assert_static(problem: RemovalProblem, need: StaticTurn) -> None:
    body, turn = problem.body, Rotation.from_quat(need.orientation).as_matrix()
    points = turn @ np.vstack((body.pivot_in_tool, problem.points)).T
    total = need.force.sum(axis=0) + body.mass * body.gravity
    # constraints of the solver: 1e-9 N and, scaled by ten, 1e-10 N m
    np.testing.assert_allclose(total, 0.0, atol=1e-8)
    np.testing.assert_allclose(np.cross(points.T, need.force).sum(axis=0), 0.0, atol=1e-9)
    np.testing.assert_array_equal(need.force[-1], 0.0)


@TURNING
def test_no_smaller_turn_is_feasible(moment: Fixture, name: str, place: int) -> None:
    problem = moment(name, place).problem
    need = smallest_turn(problem)
    # a spiral of 400 directions leaves gaps of about 10 deg; the best direction is added
    best = Rotation.from_quat(problem.orientation).inv() * Rotation.from_quat(need.orientation)
    axes = np.vstack((directions(400), best.as_rotvec() / need.angle))
    grid = [
        turned(problem, axis, share * need.angle)
        for share in (0.2, 0.5, 0.8, 0.95, 0.999)
        for axis in axes
    ]
    assert not holds(problem, Rotation.concatenate(grid)).any()
    beyond = turned(problem, axes[-1], 1.001 * need.angle)
    assert holds(problem, Rotation.concatenate([beyond])).all()


@TURNING
def test_smallest_turn_does_not_depend_on_heading_or_sign(
    moment: Fixture, name: str, place: int
) -> None:
    problem = moment(name, place).problem
    need = smallest_turn(problem)
    start = Rotation.from_quat(problem.orientation)
    for heading in (40.0, 163.0):
        about = Rotation.from_euler("z", heading, degrees=True)
        other = smallest_turn(replace(problem, orientation=-(about * start).as_quat()))
        # first order in the solver's 1e-9 over slopes of about 0.01 N per rad
        assert other.angle == pytest.approx(need.angle, abs=1e-6)


def test_no_orientation_is_found_where_there_is_none(moment: Fixture) -> None:
    problem = moment("wrench", 2).problem
    slippery = replace(problem, friction=np.full(len(problem.friction), 0.02))
    need = smallest_turn(slippery)
    assert not need.feasible
    assert np.isnan(need.angle)
    assert "N" in need.reason
    axes = directions(60)
    grid = [
        turned(slippery, axis, np.radians(angle)) for angle in (1, 5, 15, 30, 60) for axis in axes
    ]
    assert not holds(slippery, Rotation.concatenate(grid)).any()
