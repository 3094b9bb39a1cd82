"""Relocation of one finger while the others hold the tool (Xue et al., Section V)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np

from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.planning.manifold import Manifold
from pivotgait.planning.problem import RelocationProblem
from pivotgait.planning.retreat import retreat
from pivotgait.planning.rrt import Search, search
from pivotgait.planning.shortcut import path_length, shorten
from pivotgait.planning.smoothing import SmoothPath, smooth
from pivotgait.planning.time_scaling import time_path
from pivotgait.planning.trajectory import JointTrajectory
from pivotgait.planning.validity import Validity, coarse_to_fine

HOLD_TOLERANCE = 1e-6
"""How far the holds may be off at start and goal [m]."""
FINER = 4.0
"""A trajectory is checked in so many times finer steps than the search: the padding it does not
need leaves room to round corners."""
SPACINGS = (0.08, 0.04, 0.02, 0.01, 0.005, 0.0025)
"""Distances of control points [m] tried for the smooth path: the coarser, the rounder."""


@dataclass(frozen=True, eq=False)
class Relocation(FrozenArrays):
    """A planned relocation, or how far the attempt came.

    Attributes:
        found: whether there is a trajectory.
        failure: empty, or which stage failed and what bound it.
        trajectory: the timed motion, None if not found.
        q: (N, nv) path after shortcuts; of a failed attempt, empty.
        s: (N,) parameter of the tool's path along it.
        length_found: of the search's path without retreats, the sum of bounds on motion [m].
        length: of the whole path after shortcuts, retreats included [m].
        iterations: samples drawn by the search.
        nodes: of the trees from start and goal.
        nearest: what was missing between the trees, as a bound on motion [m]; 0 if found.
        counts: how often steps ended by collision, limit, projection, or stalled.
        check_step: bound on motion between two collision checks of the search [m].
        times_s: wall time of each stage [s].
    """

    found: bool
    failure: str
    trajectory: JointTrajectory | None
    q: Array
    s: Array
    length_found: float
    length: float
    iterations: int
    nodes: tuple[int, int]
    nearest: float
    counts: Mapping[str, int]
    check_step: float
    times_s: Mapping[str, float]

    def require(self) -> JointTrajectory:
        """The trajectory.

        Raises:
            InfeasibleError: if none was found; says which stage failed and what bound it.
        """
        if self.trajectory is None:
            what = f"no way found ({self.failure}; {1e3 * self.nearest:.0f} mm of motion missing)"
            mend = "choose another contact or posture, or allow more time"
            raise InfeasibleError(what, where="relocation", mend=mend)
        return self.trajectory

    def summary(self) -> Mapping[str, Any]:
        """Facts about the search as plain numbers and texts, for a phase's record."""
        return MappingProxyType(
            {
                "found": self.found,
                "failure": self.failure,
                "length_found_m": self.length_found,
                "length_m": self.length,
                "iterations": self.iterations,
                "nodes": sum(self.nodes),
                "nearest_m": self.nearest,
                "check_step_m": self.check_step,
                **{f"ended_by_{name}": count for name, count in self.counts.items()},
                **{f"{name}_s": seconds for name, seconds in self.times_s.items()},
            }
        )


def plan_relocation(problem: RelocationProblem, rng: np.random.Generator) -> Relocation:
    """Retreat along the normal, search, approach along the normal, shorten, smooth and time.

    Args:
        problem: with its options.
        rng: source of randomness; the same state gives the same plan, unless time runs out.

    Returns:
        The relocation; not found is a record too.

    Raises:
        InfeasibleError: for a start or goal beyond joint limits or in collision.
        InputError: for a start or goal off its holds.
    """
    return _Attempt(problem, rng).run()


class _Attempt:
    def __init__(self, problem: RelocationProblem, rng: np.random.Generator) -> None:
        self.problem, self.rng = problem, rng
        self.times: dict[str, float] = {}
        self.clock = perf_counter()
        check_ends(problem)
        self.manifold = Manifold(problem)
        self.validity = Validity(problem, self.manifold)
        self.fine = Validity(problem, self.manifold, self.validity.step / FINER)
        self.check_hold("start", problem.start, 0.0)
        self.check_hold("goal", problem.goal, problem.s_goal)
        self.lap("set-up")

    def run(self) -> Relocation:
        problem = self.problem
        sides = []
        for name, end, at, normal in (
            ("retreat", problem.start, 0.0, problem.start_normal),
            ("approach", problem.goal, problem.s_goal, problem.goal_normal),
        ):
            way = retreat(problem, self.manifold, self.validity, end, at, normal)
            self.lap(name)
            if way is None:
                return self.record(f"{name} along the normal: {self.binding()}")
            sides.append(way)
        ends = (sides[0][-1], 0.0), (sides[1][-1], problem.s_goal)
        found = search(problem, self.manifold, self.validity, ends, self.rng)
        self.lap("search")
        if found.outcome != "found":
            return self.record(f"search: {found.outcome}, {self.binding()}", found)
        options = problem.options
        q, s = shorten(
            self.manifold,
            self.validity,
            found.q,
            found.s,
            options.shortcuts,
            options.stride,
            self.rng,
        )
        self.lap("shortcuts")
        q = np.concatenate((sides[0][:-1], q, sides[1][-2::-1]))
        begin, end = (np.full(len(side) - 1, at) for side, (_, at) in zip(sides, ends, strict=True))
        s = np.concatenate((begin, s, end))
        trajectory = self.timed(q, s)
        self.lap("timing")
        failure = "" if trajectory is not None else f"timing: {self.binding()}"
        return self.record(failure, found, q, s, trajectory)

    def timed(self, q: Array, s: Array) -> JointTrajectory | None:
        """The roundest version of the path that is free, timed."""
        options, robot = self.problem.options, self.problem.robot
        shares = options.speed_share, options.acceleration_share
        if len(s) < 2:
            q, s = np.concatenate((q, q)), np.concatenate((s, s))
        for spacing in SPACINGS:
            path = smooth(self.manifold, q, s, robot.velocity_max, spacing)
            if path is None or not self.nodes_free(path):
                continue
            trajectory = time_path(self.manifold, path, options.sample_s, shares)
            if trajectory is not None and self.is_free(trajectory):
                return trajectory
        return None

    def nodes_free(self, path: SmoothPath) -> bool:
        """A quick look at a path before it is timed."""
        q, s = path(path.nodes)
        return all(self.fine.free(q[k], float(s[k])) for k in coarse_to_fine(len(path.nodes) - 1))

    def is_free(self, trajectory: JointTrajectory) -> bool:
        """Whether samples and the ways between them keep the collision rule."""
        q, s = trajectory.q, trajectory.s
        for k in range(len(s) - 1):
            if not self.fine.way_free(q[k], float(s[k]), q[k + 1], float(s[k + 1])):
                self.manifold.counts.collision += 1
                return False
        return True

    def check_hold(self, name: str, q: Array, s: float) -> None:
        """Refuse a configuration whose holding fingers are not at their holds."""
        chain = self.manifold.chain
        chain.update(q, *self.problem.tool.pose(s))
        error = float(np.abs(chain.residual * chain.row_lengths()).max(initial=0.0))
        if not error <= HOLD_TOLERANCE:
            what = f"a holding finger is {error:.2e} m off its hold"
            raise InputError(what, where=name, mend="project it on the closed chain first")

    def lap(self, name: str) -> None:
        """Note the time since the last lap."""
        now = perf_counter()
        self.times[name], self.clock = now - self.clock, now

    def binding(self) -> str:
        """What ended most steps."""
        counts = asdict(self.manifold.counts)
        name = max(counts, key=lambda each: counts[each])
        return f"{name} binds" if counts[name] else "nothing was tried"

    def record(
        self,
        failure: str,
        found: Search | None = None,
        q: Array | None = None,
        s: Array | None = None,
        trajectory: JointTrajectory | None = None,
    ) -> Relocation:
        """The record of success or failure."""
        problem, manifold = self.problem, self.manifold
        gap = manifold.motion(problem.start, 0.0, problem.goal, problem.s_goal)
        return Relocation(
            found=trajectory is not None,
            failure=failure,
            trajectory=trajectory,
            q=np.zeros((0, problem.robot.nv)) if q is None else q,
            s=np.zeros(0) if s is None else s,
            length_found=0.0 if found is None else path_length(manifold, found.q, found.s),
            length=0.0 if q is None or s is None else path_length(manifold, q, s),
            iterations=0 if found is None else found.iterations,
            nodes=(0, 0) if found is None else found.nodes,
            nearest=gap if found is None else found.nearest,
            counts=MappingProxyType(asdict(manifold.counts)),
            check_step=self.validity.step,
            times_s=MappingProxyType(dict(self.times)),
        )


def check_ends(problem: RelocationProblem) -> None:
    """Refuse a start or goal beyond the joint limits or in collision.

    Raises:
        InfeasibleError: naming the joint, or the two bodies and their distance.
    """
    robot, world = problem.robot, problem.world
    for name, q, s, normal in (
        ("start", problem.start, 0.0, problem.start_normal),
        ("goal", problem.goal, problem.s_goal, problem.goal_normal),
    ):
        if not robot.within_limits(q, slack=1e-9):
            beyond = robot.beyond_limits(q)
            worst = int(np.argmax(beyond))
            what = f"{robot.joint_names[worst]} is {beyond[worst]:.4f} beyond a limit or coupling"
            raise InfeasibleError(what, where=name, mend="choose a posture within the limits")
        touching = problem.holding | ({problem.finger} if normal is not None else set())
        distance, pair = world.holding(touching).clearance(q, *problem.tool.pose(s))
        if distance < world.clearance_min:
            what = f"{pair[0]} is {1e3 * distance:.2f} mm from {pair[1]}"
            mend = f"the clearance is {1e3 * world.clearance_min:.2f} mm"
            raise InfeasibleError(what, where=name, mend=mend)
