"""The finger-removal problem of Section IV-A as numbers, and what a solver answers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import PivotingTool, pivot_motion
from pivotgait.frozen import FrozenArrays
from pivotgait.plans import ToolMotion

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RemovalWeights:
    """Weights of the cost C of Section IV-A.

    Attributes:
        reorientation: of the squared angle between first and last orientation [1/rad^2].
        acceleration: lambda_1, of the time integral of |omega'|^2 [s^3/rad^2].
        alignment: lambda_2, of the time integral of sin^2 of the angles force-normal [1/s].
    """

    reorientation: float = 1.0
    acceleration: float = 1e-3
    alignment: float = 2e-2

    @property
    def as_array(self) -> Array:
        """(3,) in the order of the attributes."""
        return np.array([self.reorientation, self.acceleration, self.alignment])


@dataclass(frozen=True, eq=False)
class RemovalProblem(FrozenArrays):
    """One removal, K steps of h seconds, with n fingers that stay and one that leaves.

    Fingers are in the order staying (n), leaving; contacts in the order pivot, fingers.

    Attributes:
        steps: K.
        step_s: h [s].
        body: the tool as a body that turns about its pivot.
        orientation: (4,) start, unit quaternion xyzw, world <- tool.
        points: (n + 1, 3) contact points relative to the centre of mass, tool frame [m].
        frames: (n + 1, 3, 3) contact frames, tool <- contact, third column the inward normal.
        friction: (n + 2,) coefficients.
        normal_min: (n + 2,) [N]; 0 for the leaving finger.
        normal_max: (n + 2,) [N].
        start_force: (n + 2, 3) forces that hold the tool at rest now, world [N].
        clear_lever: (P, 3) points of the tool relative to the pivot, tool frame [m].
        clear_rise: (P,) least height of these points over the pivot [m].
        force_rate_max: bound of the change of each finger force in its contact frame [N/s];
            ``inf`` for none (the paper's problem).
        weights: of the cost.
    """

    steps: int
    step_s: float
    body: PivotingTool
    orientation: Array
    points: Array
    frames: Array
    friction: Array
    normal_min: Array
    normal_max: Array
    start_force: Array
    clear_lever: Array
    clear_rise: Array
    force_rate_max: float
    weights: RemovalWeights

    @property
    def staying(self) -> int:
        """Number of fingers that stay, n."""
        return len(self.points) - 1

    @property
    def start_local(self) -> Array:
        """(n + 1, 3) forces of the fingers at k = 0 in their contact frames [N]."""
        turn = Rotation.from_quat(self.orientation).as_matrix()
        return np.asarray(np.einsum("mil,mi->ml", turn @ self.frames, self.start_force[1:]))

    @property
    def ramp(self) -> Array:
        """(K + 1,) prescribed normal force of the leaving finger [N] (eq. 7)."""
        return float(self.start_local[-1, 2]) * (1.0 - np.arange(self.steps + 1) / self.steps)

    @property
    def rated(self) -> bool:
        """Whether the rate of the finger forces is bounded."""
        return bool(np.isfinite(self.force_rate_max))

    @property
    def change_max(self) -> float:
        """Bound of the change of a finger force from one sample to the next [N]."""
        return self.force_rate_max * self.step_s


@dataclass(frozen=True, eq=False)
class RemovalSolution(FrozenArrays):
    """A trajectory of K + 1 samples and how it was found.

    Attributes:
        orientation: (K + 1, 4) unit quaternions xyzw, world <- tool.
        angular_velocity: (K + 1, 3) world [rad/s].
        angular_acceleration: (K + 1, 3) world [rad/s^2].
        force: (K + 1, n + 2, 3) on the tool, world [N].
        cost: the weighted cost, see :func:`removal_cost`.
        solver: its name.
        iterations: of the solver.
        kkt_residual: largest scaled violation of the first-order optimality conditions
            (stationarity, feasibility, complementarity) of the discretised problem.
        multipliers: of the program's constraints, for a warm start, or None.
    """

    orientation: Array
    angular_velocity: Array
    angular_acceleration: Array
    force: Array
    cost: float
    solver: str
    iterations: int
    kkt_residual: float
    multipliers: Array | None = None

    def largest_rate(self, problem: RemovalProblem) -> float:
        """Largest rate of a finger force, seen in its contact frame [N/s]."""
        turn = Rotation.from_quat(self.orientation).as_matrix()
        frames = np.einsum("kij,mjl->kmil", turn, problem.frames)
        local = np.einsum("kmil,kmi->kml", frames, self.force[:, 1:])
        change = np.linalg.norm(np.diff(local, axis=0), axis=-1)
        return float(change.max() / problem.step_s)

    def motion(self, body: PivotingTool) -> ToolMotion:
        """The tool's motion."""
        rotation = Rotation.from_quat(self.orientation)
        return pivot_motion(body, rotation, self.angular_velocity, self.angular_acceleration)


def integrate(problem: RemovalProblem, angular_acceleration: Array) -> tuple[Array, Array]:
    """Euler integration from rest: omega_k+1 = omega_k + h sigma_k, r_k+1 = exp(h omega_k / 2) r_k.

    Args:
        problem: gives the step and the start.
        angular_acceleration: (K + 1, 3) world [rad/s^2].

    Returns:
        Orientations (K + 1, 4) and angular velocities (K + 1, 3), world.
    """
    sigma = np.asarray(angular_acceleration, dtype=float)
    omega = np.zeros_like(sigma)
    omega[1:] = problem.step_s * np.cumsum(sigma[:-1], axis=0)
    turns = Rotation.from_rotvec(problem.step_s * omega[:-1])
    rotation = Rotation.from_quat(problem.orientation)
    orientation = [rotation.as_quat()]
    for turn in turns:
        rotation = turn * rotation
        orientation.append(rotation.as_quat())
    return np.array(orientation), omega


def removal_cost(
    problem: RemovalProblem, orientation: Array, angular_acceleration: Array, force: Array
) -> float:
    """Cost C of Section IV-A, with the sums scaled by h and sin^2 in place of -cos^2.

    ``w_r 4 (1 - (r_0 . r_K)^2) + w_a h sum |sigma_k|^2 + w_n h sum sin^2(f_ik, n_ik)``: the
    first term is 4 sin^2(delta / 2), the squared angle to fourth order and smooth at 0. Sums
    run over k = 1..K (k = 0 is given); a contact without force has no angle.

    Args:
        problem: weights, step, normals.
        orientation: (K + 1, 4) unit quaternions xyzw.
        angular_acceleration: (K + 1, 3) world.
        force: (K + 1, n + 2, 3) world.
    """
    weights = problem.weights
    inner = float(orientation[0] @ orientation[-1])
    cost = weights.reorientation * 4.0 * (1.0 - inner**2)
    cost += weights.acceleration * problem.step_s * float(np.sum(angular_acceleration[1:] ** 2))
    turn = Rotation.from_quat(orientation).as_matrix()
    normals = np.empty_like(force)
    normals[:, 0] = (0.0, 0.0, 1.0)
    normals[:, 1:] = np.einsum("kij,mj->kmi", turn, problem.frames[:, :, 2])
    squared = np.sum(force**2, axis=-1)
    along = np.sum(force * normals, axis=-1) ** 2
    loaded = squared > 1e-16  # below 1e-8 N there is no force whose direction means anything
    sine = np.where(loaded, 1.0 - along / np.where(loaded, squared, 1.0), 0.0)
    return cost + weights.alignment * problem.step_s * float(np.sum(sine[1:]))
