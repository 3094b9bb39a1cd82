"""The search for a finger's way: two trees of whole configurations (Xue et al., Section V)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from time import perf_counter
from typing import Literal

import numpy as np
import pinocchio as pin

from pivotgait.exceptions import SingularCoordinatesError
from pivotgait.frozen import Array
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.steering import ARRIVED, steer
from pivotgait.planning.tree import TURN_LENGTH, Tree
from pivotgait.planning.validity import Validity

LEAST_GAIN = 0.2
"""Share of a step's wanted way below which an extension has stalled."""
MAX_STEPS = 12
"""Of one extension."""
REACHABLE_SHARE = 0.5
"""Share of sampled poses that the finger reaches from the palm's place at an end."""
SHIFTED_SHARE = 0.3
"""Share of random configurations in which palm and holding fingers are moved too."""
PALM_SHIFT = 0.03
"""Standard deviation of that shift, per joint, as a motion of the fingertips [m]."""

Outcome = Literal["found", "time limit", "node limit", "iteration limit"]


@dataclass(frozen=True, eq=False)
class Search:
    """The end of a search; a failed one is a record too.

    Attributes:
        outcome: "found", or what ran out.
        q: (N, nv) way from start to goal; empty if not found.
        s: (N,) parameter of the tool's path along it.
        iterations: samples drawn.
        nodes: of the trees from start and goal.
        nearest: least distance between the trees, as a bound on the motion of any shape [m].
        time_s: wall time [s].
    """

    outcome: Outcome
    q: Array
    s: Array
    iterations: int
    nodes: tuple[int, int]
    nearest: float
    time_s: float


class _Rrt:
    def __init__(
        self,
        problem: RelocationProblem,
        manifold: Manifold,
        validity: Validity,
        ends: tuple[tuple[Array, float], tuple[Array, float]],
        rng: np.random.Generator,
    ) -> None:
        self.options, self.manifold, self.validity = problem.options, manifold, validity
        self.rng, self.ends = rng, ends
        self.fingers = list(problem.robot.palm_columns)
        self.fingers += problem.robot.fingers[problem.finger].columns
        self.moving = list(problem.robot.fingers[problem.finger].columns)
        capacity = problem.options.max_nodes // 2 + MAX_STEPS
        self.trees = tuple(Tree(capacity, problem.robot.nv, direction) for direction in (1, -1))
        self.tips = tuple(manifold.tip(q, s) for q, s in ends)
        for tree, (q, s), tip in zip(self.trees, ends, self.tips, strict=True):
            tree.add(q, s, tip, -1)
        self.nearest = manifold.motion(*ends[0], *ends[1])

    def sample(self, side: int) -> tuple[pin.SE3, float]:
        """A fingertip pose in the tool frame and a parameter of the tool's path."""
        rng, options = self.rng, self.options
        other = self.ends[1 - side][1]
        if rng.random() < options.goal_bias:
            return self.tips[1 - side], other
        if rng.random() < REACHABLE_SHARE:
            base, s = self.ends[int(rng.integers(2))]
            return self.manifold.tip(self._posture(base), s), s
        one, two = (tip.translation for tip in self.tips)
        low = np.minimum(one, two) - options.sample_margin
        high = np.maximum(one, two) + options.sample_margin
        axis = rng.normal(size=3)
        axis *= rng.uniform(0.0, options.turn_limit) / np.linalg.norm(axis)
        middle = pin.SE3.Interpolate(self.tips[0], self.tips[1], rng.random()).rotation
        s = float(rng.uniform(self.ends[0][1], self.ends[1][1]))
        return pin.SE3(pin.exp3(axis) @ middle, rng.uniform(low, high)), s

    def extend(self, side: int, sample: pin.SE3, s_sample: float) -> int | None:
        """Follow a sampled pose from the nearest node; the last node, None if there is none."""
        tree, manifold, counts = self.trees[side], self.manifold, self.manifold.counts
        place = tree.nearest_tip(sample, s_sample)
        q, s = tree.q[place], float(tree.s[place])
        error = self._error(manifold.tip(q, s), sample)
        begun, target_q = place, self.ends[1 - side][0]
        steps = max(int(np.ceil(error / self.options.stride)), 1)
        for k in range(min(steps, MAX_STEPS)):
            s_next = s + (s_sample - s) / (steps - k)
            wanted = np.zeros(len(q))
            pull = self.options.null_gain * (target_q - q)[self.fingers]
            wanted[self.fingers] = pull
            try:
                change = manifold.step(q, s_next, sample, self.options.stride, wanted)
            except SingularCoordinatesError:
                counts.projection += 1
                break
            long = manifold.motion(q, s, q + change, s_next)
            change *= min(1.0, 2.0 * self.options.stride / max(long, ARRIVED))
            settled = manifold.settle(q + change, s_next)
            if settled is None:
                break
            tip = manifold.tip(settled, s_next)
            left = self._error(tip, sample)
            if left > error - LEAST_GAIN * min(self.options.stride, error):
                counts.stalled += 1
                break
            if not self.validity.way_free(q, s, settled, s_next):
                counts.collision += 1
                break
            place = tree.add(settled, s_next, tip, place)
            q, s, error = settled, s_next, left
        return None if place == begun else place

    def explore(self, side: int) -> int | None:
        """Go towards a random configuration from the nearest node; the last node or None."""
        rng = self.rng
        q = self._posture(self.ends[int(rng.integers(2))][0])
        if rng.random() < SHIFTED_SHARE:
            q += rng.normal(size=len(q)) * PALM_SHIFT / np.sqrt(self.manifold.metric)
        s = float(rng.uniform(self.ends[0][1], self.ends[1][1]))
        target = self.manifold.settle(q, s)
        if target is None:
            return None
        place = self.trees[side].nearest(target, s, self.manifold.metric)
        last, _ = self._walk(side, place, target, s, MAX_STEPS)
        return None if last == place else last

    def _posture(self, q: Array) -> Array:
        """q with a random posture of the moving finger."""
        robot, columns = self.manifold.robot, self.moving
        posture = q.copy()
        posture[columns] = self.rng.uniform(robot.lower[columns], robot.upper[columns])
        return posture

    def connect(self, side: int, q_target: Array, s_target: float) -> int | None:
        """Go from the nearest node to a state of the other tree; its node, None if not reached."""
        place = self.trees[side].nearest(q_target, s_target, self.manifold.metric)
        place, left = self._walk(side, place, q_target, s_target, self.options.max_nodes)
        self.nearest = min(self.nearest, left)
        return place if left <= ARRIVED else None

    def _walk(
        self, side: int, place: int, q_target: Array, s_target: float, most: int
    ) -> tuple[int, float]:
        """Projected straight line in the joints; its last node and what is left of it [m]."""
        tree = self.trees[side]
        begin = tree.q[place], float(tree.s[place])
        line = steer(self.manifold, self.validity, begin, (q_target, s_target), self.options.stride)
        for q, s in islice(line, min(most, len(tree.s) - tree.size)):
            place = tree.add(q, s, self.manifold.tip(q, s), place)
        left = self.manifold.motion(tree.q[place], float(tree.s[place]), q_target, s_target)
        return place, left

    def way(self, places: tuple[int, int]) -> tuple[Array, Array]:
        """From the root of the first tree to that of the second through nodes that agree."""
        (q_a, s_a), (q_b, s_b) = (
            tree.branch(place) for tree, place in zip(self.trees, places, strict=True)
        )
        return np.concatenate((q_a, q_b[-2::-1])), np.concatenate((s_a, s_b[-2::-1]))

    @staticmethod
    def _error(tip: pin.SE3, target: pin.SE3) -> float:
        turn = pin.log3(tip.rotation.T @ target.rotation)
        away = np.linalg.norm(tip.translation - target.translation)
        return float(away + TURN_LENGTH * np.linalg.norm(turn))


def search(
    problem: RelocationProblem,
    manifold: Manifold,
    validity: Validity,
    ends: tuple[tuple[Array, float], tuple[Array, float]],
    rng: np.random.Generator,
) -> Search:
    """Grow a tree from each end until they meet.

    As in Section V: a sampled SE(3) pose of the moving fingertip, the nearest node, steps by the
    stacked rows (9) and (10) with palm and finger pulled to the other end in their null space,
    Newton's method back onto (9), each node a whole configuration. What differs, and why:

    * The goal is a whole configuration, which steps in the fingertip's pose alone do not hit. A
      second tree grows from it, and each extension is followed by an attempt to join the trees.
    * A share of the samples are configurations instead of poses, half of the poses are ones that
      the finger reaches: four joints follow few of the poses in a box.
    * The pseudo-inverse is damped and weighted, because a finger rarely follows six rows.

    Trees are joined, and configurations approached, on a straight line in the joints that is
    projected on (9) step by step (RRT-Connect).

    Args:
        problem: with its options.
        manifold: of the problem.
        validity: of the problem.
        ends: states (q, s) that are free.
        rng: source of randomness.
    """
    began = perf_counter()
    rrt = _Rrt(problem, manifold, validity, ends, rng)
    iterations, side = 0, 0
    places: tuple[int, int] | None = None
    outcome: Outcome = "time limit"
    met = rrt.connect(1, *ends[0])
    if met is not None:
        places = (0, met)
    while places is None and perf_counter() - began < problem.options.time_limit_s:
        if any(tree.size + MAX_STEPS >= len(tree.s) for tree in rrt.trees):
            outcome = "node limit"
            break
        if iterations == problem.options.max_iterations:
            outcome = "iteration limit"
            break
        iterations += 1
        if rng.random() < problem.options.pose_share:
            grown = rrt.extend(side, *rrt.sample(side))
        else:
            grown = rrt.explore(side)
        if grown is not None:
            tree = rrt.trees[side]
            met = rrt.connect(1 - side, tree.q[grown], float(tree.s[grown]))
            if met is not None:
                places = (grown, met) if side == 0 else (met, grown)
        side = 1 - side
    nv = problem.robot.nv
    q, s = (np.zeros((0, nv)), np.zeros(0)) if places is None else rrt.way(places)
    return Search(
        outcome="found" if places is not None else outcome,
        q=q,
        s=s,
        iterations=iterations,
        nodes=(rrt.trees[0].size, rrt.trees[1].size),
        nearest=rrt.nearest,
        time_s=perf_counter() - began,
    )
