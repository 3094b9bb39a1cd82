"""The configurations in which the holding fingers keep their holds (Xue et al., eq. 9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array, frozen
from pivotgait.kinematics import ClosedChain, project
from pivotgait.planning.problem import RelocationProblem

TOLERANCE = 1e-9
"""Of the holds' scaled residual in a smooth path [m]."""
SEARCH_TOLERANCE = 1e-5
"""The same in the search, whose padding covers far more and whose states are projected again."""
LIMIT_RESERVE = 1e-3
"""Share of a joint's range that stays free at its ends, so that smoothing keeps the limits."""
CLIPS = 4
"""Rounds of projection and clipping at limits."""
MIN_REACH = 0.03
"""Least lever in the metric of steps [m]."""
HARD, TIP_DAMPING, TURN_DAMPING, GAP_DAMPING = 1e-10, 1e-3, 0.3, 1.0
"""Damping of the stacked rows, relative to their own size: of holds, tip position, tip
orientation and gaps. A finger of four joints can follow a position but rarely an orientation."""
LEAST_DIAGONAL = 1e-9
"""Added to a row's size, so that rows without any mobile joint do no harm."""
ROUNDING = 1e-12

FAR = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass
class Counts:
    """Why steps of the search ended.

    Attributes:
        collision: nearer than the clearance.
        limit: a joint limit or coupling.
        projection: Newton's method on eq. (9) did not converge.
        stalled: no progress towards the sample.
    """

    collision: int = 0
    limit: int = 0
    projection: int = 0
    stalled: int = 0


class Manifold:
    """Projection on eq. (9), steps along it, joint limits and the bound on motion.

    A state is (q, s): joint positions and the parameter of the tool's path.
    """

    def __init__(self, problem: RelocationProblem) -> None:
        robot, world = problem.robot, problem.world
        self.robot, self.tool = robot, problem.tool
        self.chain = ClosedChain(robot, problem.holds)
        self.counts = Counts()
        self.metric = np.maximum(world.reach, MIN_REACH) ** 2
        self._bounds, self._change = world.bounds, np.zeros(robot.nv)
        self._tool_radius = world.tool_radius
        self._tip = robot.fingers[problem.finger].tip_frame_id
        self._data = robot.model.createData()
        reserve = LIMIT_RESERVE * (robot.upper - robot.lower)
        ends = np.stack((problem.start, problem.goal))
        self._lower = frozen(np.minimum(robot.lower + reserve, ends.min(axis=0)))
        self._coupling_reserves = [
            float(min(reserve[i], (ends[:, k] - ends[:, i]).min())) for i, k in robot.couplings
        ]
        self._upper = frozen(np.maximum(robot.upper - reserve, ends.max(axis=0)))

    def motion(self, qa: Array, sa: float, qb: Array, sb: float) -> float:
        """Bound on the relative motion of any two shapes from one state to the other [m]."""
        np.subtract(qb, qa, out=self._change)
        np.abs(self._change, out=self._change)
        # Of six numbers, Python's max is several times as fast as NumPy's.
        moved: float = max(self._bounds.dot(self._change).tolist())
        if not self.tool.moves or sa == sb:
            return moved
        (turn_a, at_a), (turn_b, at_b) = self.tool.pose(sa), self.tool.pose(sb)
        chord = float(np.linalg.norm(turn_b - turn_a)) / np.sqrt(2.0)
        return float(moved + np.linalg.norm(at_b - at_a) + chord * self._tool_radius)

    def motions(self, q: Array, s: Array) -> Array:
        """(N - 1,) bounds on motion between neighbours among states q (N, nv), s (N,) [m]."""
        if self.tool.moves:
            steps = range(len(s) - 1)
            each = [self.motion(q[k], float(s[k]), q[k + 1], float(s[k + 1])) for k in steps]
            return np.array(each)
        return np.asarray((np.abs(np.diff(q, axis=0)) @ self._bounds.T).max(axis=1, initial=0.0))

    def settle(self, q: Array, s: float, tolerance: float = SEARCH_TOLERANCE) -> Array | None:
        """The nearest configuration that holds the tool and keeps the limits, None if none."""
        pose, stuck = self.tool.pose(s), frozenset[int]()
        q = self._clipped(q)
        for _ in range(CLIPS):
            try:
                found = project(
                    self.chain,
                    q,
                    *pose,
                    tolerance=tolerance,
                    max_iterations=6,
                    weights=self.metric,
                    fixed=tuple(stuck),
                )
            except SingularCoordinatesError:
                break
            if not found.converged:
                if stuck:
                    self.counts.limit += 1
                    return None
                break
            q = self._clipped(found.q)
            moved = np.abs(q - found.q) > 1e-12
            if not moved.any():
                return found.q
            # Joints that met a limit stay there while the others close the chain again.
            stuck |= set(np.flatnonzero(moved).tolist())
        else:
            self.counts.limit += 1
            return None
        self.counts.projection += 1
        return None

    def _clipped(self, q: Array) -> Array:
        """Inside limits and couplings."""
        inside = np.minimum(np.maximum(q, self._lower), self._upper)
        for (i, k), reserve in zip(self.robot.couplings, self._coupling_reserves, strict=True):
            excess = inside[i] - inside[k] + reserve
            if excess > 0.0:
                inside[i] -= 0.5 * excess
                inside[k] += 0.5 * excess
        return inside

    def tip_in_world(self, q: Array) -> pin.SE3:
        """Pose of the moving fingertip, world."""
        pin.forwardKinematics(self.robot.model, self._data, q)
        return pin.updateFramePlacement(self.robot.model, self._data, self._tip)

    def tip(self, q: Array, s: float) -> pin.SE3:
        """Pose of the moving fingertip in the tool frame."""
        return pin.SE3(*_fortran(self.tool.pose(s))).actInv(self.tip_in_world(q))

    def hold_error(self, q: Array, s: float) -> float:
        """Largest distance of a holding tip's centre from its place on the tool [m]."""
        pin.forwardKinematics(self.robot.model, self._data, q)
        turn, position = self.tool.pose(s)
        errors = [0.0]
        for hold in self.chain.holds:
            frame = hold.finger.tip_frame_id
            tip = pin.updateFramePlacement(self.robot.model, self._data, frame).translation
            errors.append(float(np.linalg.norm(tip - position - turn.dot(hold.centre))))
        return max(errors)

    def step(
        self,
        q: Array,
        s: float,
        target: pin.SE3,
        longest: float,
        wanted: Array,
        *,
        turning: bool = True,
        gaps: tuple[Array, Array] | None = None,
    ) -> Array:
        """Change of q that takes the moving fingertip towards a pose (eqs 9 and 10, stacked).

        dq = wanted + A+ (b - A wanted), which is A+ b + (I - A+ A) wanted, with a damped and
        weighted pseudo-inverse: the rows of the holds are all but exact, those of the tip give
        way where the finger cannot follow.

        Args:
            q: (nv,) configuration.
            s: the tool's path parameter at the end of the step.
            target: fingertip pose in the tool frame.
            longest: way of the fingertip's centre [m], and turn [rad] per ``longest`` / 0.03 m.
            wanted: (nv,) change of the joints that the rows leave free.
            turning: whether the tip's orientation is followed too.
            gaps: gradients (M, nv) of distances that should grow, and by how much (M,) [m].

        Raises:
            SingularCoordinatesError: where the local coordinates are singular.
        """
        pose = self.tool.pose(s)
        self.chain.update(q, *pose)
        model, data = self.robot.model, self.chain.data
        tip = pin.updateFramePlacement(model, data, self._tip)
        jacobian = pin.getFrameJacobian(model, data, self._tip, FAR)
        goal = pin.SE3(*_fortran(pose)).act(target)
        way = goal.translation - tip.translation
        way *= min(1.0, longest / (np.linalg.norm(way) + 1e-12))
        rows, right = [self.chain.jacobian, jacobian[:3]], [-self.chain.residual, way]
        if turning:
            turn = pin.log3(goal.rotation @ tip.rotation.T)
            turn *= min(1.0, longest / MIN_REACH / (np.linalg.norm(turn) + 1e-12))
            rows.append(jacobian[3:])
            right.append(turn)
        turned = sum(len(each) for each in right)
        if gaps is not None:
            rows.append(gaps[0])
            right.append(gaps[1])
        matrix, b = np.concatenate(rows), np.concatenate(right)
        damping = np.full(len(b), HARD)
        damping[self.chain.rows :] = TIP_DAMPING
        damping[self.chain.rows + 3 : turned] = TURN_DAMPING
        if gaps is not None:
            damping[turned:] = GAP_DAMPING
        mobility = 1.0 / self.metric
        for _ in range(CLIPS):
            change = wanted + _damped(matrix, b - matrix @ wanted, mobility, damping)
            beyond = (q + change < self._lower - ROUNDING) | (q + change > self._upper + ROUNDING)
            if not beyond.any():
                break
            # Joints that would pass a limit stay, and the others take their part.
            mobility = np.where(beyond, 0.0, mobility)
            wanted = np.where(beyond, 0.0, wanted)
        return change


def _damped(matrix: Array, right: Array, mobility: Array, damping: Array) -> Array:
    """Weighted pseudo-inverse of a matrix times a vector, with relative damping of each row."""
    weighted = matrix * mobility
    gram = weighted @ matrix.T
    gram.flat[:: len(right) + 1] += damping * (gram.diagonal() + LEAST_DIAGONAL)
    _, multipliers, failed = dposv(gram, right)
    return weighted.T @ multipliers if failed == 0 else np.zeros(matrix.shape[1])


def _fortran(pose: tuple[Array, Array]) -> tuple[Array, Array]:
    """Writable copies: Pinocchio's bindings refuse read-only arrays."""
    return np.array(pose[0]), np.array(pose[1])
