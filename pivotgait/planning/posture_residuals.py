"""What a chain of hand postures is asked for, as residuals with analytic Jacobians.

For each key pose: tips at their contacts, contacts on the pads, joints within limits and
couplings, clearance; between key poses: a contact that lasts is seen by its fingertip in one
direction (rolling is held to zero, Xue et al., eq. 9), and postures stay near one another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pivotgait.frozen import Array
from pivotgait.kinematics.conditioning import ANGLE_LENGTH
from pivotgait.kinematics.dexterity import dexterity
from pivotgait.kinematics.rigid_motion import cross_matrix
from pivotgait.models import Finger, Robot
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose, check_fingers, held_on


@dataclass(frozen=True)
class PostureWeights:
    """What one unit of each residual is; a residual of 1 is a clear fault.

    Attributes:
        position: distance of a tip from its place [m].
        direction: change of the direction in which a tip sees a lasting contact [rad].
        pad: cosine by which a contact leaves the pad's cone.
        clearance: missing distance [m].
        clearance_wish: distance wished for beyond the clearance asked for [m].
        idle_wish: the same for fingers that do not touch the tool: they have room.
        limit: share of a joint's range by which its limit's margin is entered.
        limit_margin: margin to joint limits, share of the range.
        coupling: joint angle by which a coupling is broken [rad].
        coupling_margin: angle by which couplings are to be kept [rad].
        dexterity: missing distance of a finger from its singularity [m].
        dexterity_wish: distance from it that is wished for [m].
        home: share of a joint's range away from home.
        change: share of a joint's range between neighbouring key poses.
    """

    position: float = 1e-3
    direction: float = 0.02
    pad: float = 0.05
    clearance: float = 1e-3
    clearance_wish: float = 1e-3
    idle_wish: float = 6e-3
    limit: float = 0.03
    limit_margin: float = 0.05
    coupling: float = 0.05
    coupling_margin: float = 0.08
    dexterity: float = 5e-4
    dexterity_wish: float = 3e-3
    home: float = 50.0
    change: float = 3.0


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Cost and Gauss-Newton model of residuals that join neighbours only.

    Attributes:
        cost: r^T r.
        gradient: (K nv,) J^T r.
        normal: (K nv, K nv) J^T J, block tridiagonal.
    """

    cost: float
    gradient: Array
    normal: Array


class PostureResiduals:
    """Residuals of postures (K, nv) at K key poses, as normal equations.

    Args:
        robot: the arm-hand.
        keys: in the order of time.
        world: for the clearance; None leaves collisions out.
        weights: what each residual is measured in.
    """

    def __init__(
        self,
        robot: Robot,
        keys: Sequence[KeyPose],
        world: CollisionWorld | None = None,
        weights: PostureWeights | None = None,
    ) -> None:
        check_fingers(keys, robot)
        self.robot, self.keys, self.weights = robot, tuple(keys), weights or PostureWeights()
        self.lasting = held_on(self.keys)
        self._data = robot.model.createData()
        self._range = robot.upper - robot.lower
        # A joint that turns more than once (a SCARA's last) is no better in its middle.
        span = np.where(self._range > 2.0 * np.pi, np.inf, self._range)
        self._home, self._change = (
            1.0 / (w * span) for w in (self.weights.home, self.weights.change)
        )
        self._worlds = [world and world.holding(frozenset(key.contacts)) for key in self.keys]
        self._idle = [
            [c for name, f in robot.fingers.items() if name not in key.contacts for c in f.columns]
            for key in self.keys
        ]

    def normal_equations(self, postures: Array) -> NormalEquations:
        """Cost, gradient and J^T J at postures (K, nv) [rad] or [m]."""
        n, count = self.robot.nv, len(self.keys)
        gradient, normal = np.zeros((count, n)), np.zeros((count, n, count, n))
        seen: dict[tuple[str, int], tuple[Array, Array]] = {}
        cost = self._joints(postures, gradient, normal)
        for k in range(count):
            residual, jacobian = self._pose(k, postures[k], seen)
            cost += float(residual @ residual)
            gradient[k] += residual @ jacobian
            normal[k, :, k] += jacobian.T @ jacobian
        scale = 1.0 / self.weights.direction
        for finger, k, following in self.lasting:
            (one, by_one), (other, by_other) = seen[finger, k], seen[finger, following]
            turned, sides = scale * (one - other), ((k, by_one), (following, -by_other))
            cost += float(turned @ turned)
            for place, jacobian in sides:
                gradient[place] += scale * (turned @ jacobian)
                for beside, other_jacobian in sides:
                    normal[place, :, beside] += scale**2 * (jacobian.T @ other_jacobian)
        return NormalEquations(cost, gradient.ravel(), normal.reshape(count * n, count * n))

    def _joints(self, postures: Array, gradient: Array, normal: Array) -> float:
        """Add the residuals of single joints and of their couplings; returns their cost."""
        robot, weights = self.robot, self.weights
        margin, scale = weights.limit_margin * self._range, 1.0 / (weights.limit * self._range)
        home = self._home * (postures - robot.home)
        low = np.maximum(robot.lower + margin - postures, 0.0) * scale
        high = np.maximum(postures - robot.upper + margin, 0.0) * scale
        gradient += self._home * home + scale * (high - low)
        diagonal = self._home**2 + scale**2 * ((low > 0.0) | (high > 0.0))
        cost = float(np.sum(home**2) + np.sum(low**2) + np.sum(high**2))
        change = self._change * np.diff(postures, axis=0)
        cost += float(np.sum(change**2))
        gradient[1:] += self._change * change
        gradient[:-1] -= self._change * change
        diagonal[1:] += self._change**2
        diagonal[:-1] += self._change**2
        joints = np.arange(robot.nv)
        for k in range(len(postures)):
            normal[k, joints, k, joints] += diagonal[k]
        for k in range(len(postures) - 1):
            normal[k, joints, k + 1, joints] -= self._change**2
            normal[k + 1, joints, k, joints] -= self._change**2
        for i, j in robot.couplings:
            broken = postures[:, i] - postures[:, j] + weights.coupling_margin
            for k in map(int, np.flatnonzero(broken > 0.0)):
                cost += float((broken[k] / weights.coupling) ** 2)
                for column, sign in ((i, 1.0), (j, -1.0)):
                    gradient[k, column] += sign * broken[k] / weights.coupling**2
                    normal[k, column, k, i] += sign / weights.coupling**2
                    normal[k, column, k, j] -= sign / weights.coupling**2
        return cost

    def _pose(
        self, k: int, q: Array, seen: dict[tuple[str, int], tuple[Array, Array]]
    ) -> tuple[Array, Array]:
        """Residuals of one key pose by its own posture; notes the directions of its contacts."""
        key, weights = self.keys[k], self.weights
        parts = [self._clearance(k, q)]
        for name, (error, by_q, direction, turned) in self.tips(key, q).items():
            finger = self.robot.fingers[name]
            seen[name, k] = direction, turned
            parts.append((error / weights.position, by_q / weights.position))
            missing = np.cos(finger.pad_cone) - finger.pad @ direction
            if missing > 0.0:
                by_pad = -(finger.pad @ turned) / weights.pad
                parts.append((np.array([missing / weights.pad]), by_pad[None]))
            parts.append(self._dexterity(finger, key))
        residuals, jacobians = zip(*parts, strict=True)
        return np.concatenate(residuals), np.concatenate(jacobians)

    def tips(self, key: KeyPose, q: Array) -> dict[str, tuple[Array, Array, Array, Array]]:
        """For each finger that touches: how far its tip is off, and the direction of its contact.

        Returns:
            finger -> error (3,) world [m], its Jacobian (3, nv), direction from the tip's centre
            to the contact (3,) in the tip frame, its Jacobian (3, nv).
        """
        model, data = self.robot.model, self._data
        pin.computeJointJacobians(model, data, q)
        found: dict[str, tuple[Array, Array, Array, Array]] = {}
        for name, contact in key.contacts.items():
            finger = self.robot.fingers[name]
            placement = pin.updateFramePlacement(model, data, finger.tip_frame_id)
            jacobian = self._tip_jacobian(finger)
            inward = key.rotation @ contact.normal
            place = key.position + key.rotation @ contact.point - finger.tip_radius * inward
            turn = placement.rotation.T
            # d(R^T n) = R^T (n x w) for a tip that turns with w.
            by_turn = turn @ cross_matrix(inward) @ jacobian[3:]
            found[name] = (placement.translation - place, jacobian[:3], turn @ inward, by_turn)
        return found

    def _dexterity(self, finger: Finger, key: KeyPose) -> tuple[Array, Array]:
        jacobian = self._tip_jacobian(finger)
        inward = key.rotation @ key.contacts[finger.name].normal
        wish, scale = self.weights.dexterity_wish, 1.0 / self.weights.dexterity
        distance, by_q = dexterity(jacobian, inward, finger.columns, ANGLE_LENGTH, below=wish)
        if by_q is None:
            return np.zeros(0), np.zeros((0, self.robot.nv))
        return np.array([scale * (wish - distance)]), -scale * by_q[None]

    def _tip_jacobian(self, finger: Finger) -> Array:
        """(6, nv) of the tip's centre, world axes, at the last computed joint Jacobians."""
        model, data = self.robot.model, self._data
        return np.asarray(
            pin.getFrameJacobian(model, data, finger.tip_frame_id, pin.LOCAL_WORLD_ALIGNED)
        )

    def _clearance(self, k: int, q: Array) -> tuple[Array, Array]:
        world, key, weights = self._worlds[k], self.keys[k], self.weights
        if world is None:
            return np.zeros(0), np.zeros((0, self.robot.nv))
        idle = self._idle[k]
        wish = max(weights.clearance_wish, weights.idle_wish if idle else 0.0)
        near = world.near(q, key.rotation, key.position, world.clearance_min + wish)
        distance = np.array([each for each, _ in near])
        gradient = np.array([slope for _, slope in near]).reshape(len(near), self.robot.nv)
        free = np.any(gradient[:, idle] != 0.0, axis=1)
        wanted = np.where(free, weights.idle_wish, weights.clearance_wish) + world.clearance_min
        wanting = distance < wanted
        missing = (wanted - distance)[wanting]
        return missing / weights.clearance, -gradient[wanting] / weights.clearance
