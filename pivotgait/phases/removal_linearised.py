"""The removal problem linearised about a trajectory, as a sparse second-order cone program.

Nothing here comes from the CasADi program: world-frame dynamics, forces in contact frames,
orientation errors R = Exp(a) R_bar, derivatives by hand (checked by finite differences in the
tests). Cones (5) and bounds (6) stay exact; dynamics and clearance are linearised; the cost is
replaced by its Gauss-Newton model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial.transform import Rotation

from pivotgait.contacts.grasp_map import skew
from pivotgait.dynamics import world_inertia
from pivotgait.phases.removal_problem import RemovalProblem, integrate

Array = NDArray[np.float64]
Index = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A nominal trajectory, k = 1..K: accelerations and forces; orientation follows from them.

    Attributes:
        sigma: (K, 3) angular accelerations, world [rad/s^2].
        local: (K, n + 1, 3) finger forces in their contact frames [N].
        rotation: (K, 3, 3) world <- tool, by Euler integration of ``sigma``.
        omega: (K, 3) angular velocities, world [rad/s].
    """

    sigma: Array
    local: Array
    rotation: Array
    omega: Array

    @classmethod
    def of(cls, problem: RemovalProblem, sigma: Array, local: Array) -> Trajectory:
        """Integrate the accelerations; sigma_0 = 0."""
        orientation, omega = integrate(problem, np.vstack((np.zeros(3), sigma)))
        turn = Rotation.from_quat(orientation[1:]).as_matrix()
        return cls(sigma, local, turn, omega[1:])


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Moment residual about the pivot and table force along a trajectory, with derivatives.

    ``moment`` (K, 3) [N m] is zero on a solution; ``table`` (K, 3) [N], world, is what force
    balance leaves to the table. Derivatives are with respect to a, omega, sigma (K, 3, 3) and
    the local finger forces (K, 3, 3 (n + 1)).
    """

    moment: Array
    table: Array
    moment_by: tuple[Array, Array, Array, Array]
    table_by: tuple[Array, Array, Array, Array]


def dynamics(problem: RemovalProblem, trajectory: Trajectory) -> Dynamics:
    """Evaluate eq. (3) about the pivot, world frame, and differentiate it."""
    body, turn = problem.body, trajectory.rotation
    omega, sigma = trajectory.omega, trajectory.sigma
    arm = -(turn @ body.pivot_in_tool)
    cross_arm, cross_omega, cross_sigma = skew(arm), skew(omega), skew(sigma)
    inertia = world_inertia(body.inertia_about_pivot, Rotation.from_matrix(turn))
    weight = body.mass * body.gravity

    frames = np.einsum("kij,mjl->kmil", turn, problem.frames)
    levers = np.einsum("kij,mj->kmi", turn, problem.points - body.pivot_in_tool)
    push = np.einsum("kmil,kml->kmi", frames, trajectory.local)
    moment_of = np.einsum("kmij,kmjl->kmil", skew(levers), frames)
    finger_moment = np.einsum("kmil,kml->ki", moment_of, trajectory.local)
    finger_force = push.sum(axis=1)

    spin = np.einsum("kij,kj->ki", inertia, omega)
    thrust = np.einsum("kij,kj->ki", inertia, sigma)
    centripetal = np.cross(omega, np.cross(omega, arm))
    moment = thrust + np.cross(omega, spin) - np.cross(arm, weight) - finger_moment
    table = body.mass * (np.cross(sigma, arm) + centripetal - body.gravity) - finger_force

    turned_spin = inertia @ cross_omega - skew(spin)
    moment_a = (
        inertia @ cross_sigma
        - skew(thrust)
        + cross_omega @ turned_spin
        - skew(weight) @ cross_arm
        + skew(finger_moment)
    )
    moment_omega = cross_omega @ inertia - skew(spin)
    table_a = -body.mass * (cross_sigma @ cross_arm + cross_omega @ cross_omega @ cross_arm) + skew(
        finger_force
    )
    table_omega = -body.mass * (skew(np.cross(omega, arm)) + cross_omega @ cross_arm)

    def stacked(blocks: Array) -> Array:
        return np.swapaxes(blocks, 1, 2).reshape(len(blocks), 3, -1)

    return Dynamics(
        moment,
        table,
        (moment_a, moment_omega, inertia, -stacked(moment_of)),
        (table_a, table_omega, -body.mass * cross_arm, -stacked(frames)),
    )


class Rows:
    """Collects blocks of a sparse matrix and its right-hand side."""

    def __init__(self, columns: int) -> None:
        self._columns, self.count = columns, 0
        self._i: list[Any] = []
        self._j: list[Any] = []
        self._v: list[Any] = []
        self.side: list[Array] = []

    def open(self, side: Array) -> Index:
        """Reserve rows with this right-hand side; returns their numbers in its shape."""
        rows = self.count + np.arange(side.size).reshape(side.shape)
        self.count += side.size
        self.side.append(np.ravel(side))
        return rows

    def put(self, rows: Index, columns: Index, blocks: Array) -> None:
        """Add blocks (..., r, c) at rows (..., r) and columns (..., c)."""
        shape = (*rows.shape, columns.shape[-1])
        self._i.append(np.broadcast_to(rows[..., :, None], shape).ravel())
        self._j.append(np.broadcast_to(columns[..., None, :], shape).ravel())
        self._v.append(np.broadcast_to(blocks, shape).ravel())

    def matrix(self) -> Any:
        """The sparse matrix in CSC form; entries at one place add up."""
        entries = (np.concatenate(self._v), (np.concatenate(self._i), np.concatenate(self._j)))
        return sparse.csc_matrix(entries, shape=(self.count, self._columns))


def left_jacobian(turn: Array) -> Array:
    """(N, 3, 3) J with Exp(v + d) = Exp(J d) Exp(v) to first order, of rotation vectors (N, 3)."""
    cross = skew(turn)
    angle2 = np.sum(turn**2, axis=-1)[:, None, None]
    small = angle2 < 1e-8
    safe = np.where(small, 1.0, angle2)
    angle = np.sqrt(safe)
    first = np.where(small, 0.5 - angle2 / 24.0, (1.0 - np.cos(angle)) / safe)
    second = np.where(small, 1.0 / 6.0 - angle2 / 120.0, (angle - np.sin(angle)) / (safe * angle))
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)


def slope(force: Array) -> tuple[Array, Array]:
    """rho = f_t / |f| (..., 2), whose square is sin^2, and its derivative (..., 2, 3)."""
    size = np.linalg.norm(force, axis=-1)
    unit = force / size[..., None]
    rho = unit[..., :2]
    derivative = np.eye(2, 3) - rho[..., :, None] * unit[..., None, :]
    return rho, derivative / size[..., None, None]
