"""Relocation of a finger against OMPL's constrained RRT, and where its time goes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.frozen import Array
from pivotgait.kinematics import ClosedChain, Hold, project
from pivotgait.models import attitude, load_scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.manifold import TOLERANCE, Manifold
from pivotgait.planning.problem import RelocationOptions, RelocationProblem
from pivotgait.planning.relocation import plan_relocation
from pivotgait.planning.retreat import retreat
from pivotgait.planning.rrt import search
from pivotgait.planning.tool_path import PivotingTool
from pivotgait.planning.validity import Validity

CLEARANCE = 1e-3  # [m]
TIME_LIMIT_S = 5.0
PITCH, ROLL = np.radians((25.0, 90.0))
PIVOT_XY = (0.55, 0.0)  # [m]
PLACES = {"thumb": (0.035, 0.0), "index": (0.035, 180.0), "middle": (0.015, 230.0)}
"""Of the contacts: along the handle [m], around it [deg]."""
NEXT_INDEX = (0.045, 180.0)
"""Where the index finger goes to from its contact."""
GRIP = np.array(
    [
        *(0.49780526, -2.19334399, 0.15041699, 1.75279261),  # arm
        *(0.16056965, -0.33549138),  # wrist
        *(-0.13142591, -0.19224229, 1.28509988, 0.82555494),  # index
        *(-0.22573616, 0.25541662, 0.77562959, 0.75562687),  # middle
        *(0.78361708, 0.94233649, 0.07523072, 0.04624159, 0.01565326),  # thumb
    ]
)
"""The knife held by three fingers: least squares from random starts."""
GRIP_AFTER = np.array(
    [
        *(0.51278809, -2.1694636, 0.14990707, 1.72683104),
        *(0.16057046, -0.33548458),
        *(-0.31002677, -0.19991927, 1.4168647, 0.72308366),
        *(-0.20118899, 0.27365666, 0.91153583, 0.57649007),
        *(0.66494795, 0.95302068, 0.07725432, 0.14907884, 0.0325693),
    ]
)
"""The same with the index finger at its next place."""
LIFTED = (0.1502, -0.1081, 0.0885, 0.0477)
"""Middle finger stretched, in the air [rad]."""
CURLED = (-0.14, -0.2, 1.48, 1.18)
"""Middle finger in the air with its last two joints bent: its straight way is blocked [rad]."""


@dataclass(frozen=True, eq=False)
class Grip:
    """The knife of the built-in scene, lifted by 25 degrees and held by three fingers.

    Attributes:
        world: collisions of arm-hand, knife and table.
        tool: at rest.
        holds: by finger, at ``q``.
        q: (nv,) that holds it.
    """

    world: CollisionWorld
    tool: PivotingTool
    holds: dict[str, Hold]
    q: Array


def knife_grip() -> Grip:
    """The grip from which the benchmark's problems start."""
    scene = load_scene("knife")
    robot, tool = scene.robot, scene.tool
    assert robot is not None
    turn = np.ascontiguousarray(attitude(0.0, PITCH, ROLL).as_matrix())
    position = np.array([*PIVOT_XY, tool.tip_radius]) - turn @ tool.pivot_in_tool
    holds = {}
    for finger, (along, around) in PLACES.items():
        place = tool.place(along, np.radians(around))
        given = robot.fingers[finger], place.point, place.normal
        holds[finger] = Hold.at(robot, GRIP, turn, *given)
    q = project(ClosedChain(robot, tuple(holds.values())), GRIP, turn, position).q
    world = CollisionWorld(robot, tool, 0.0, CLEARANCE)
    return Grip(world, PivotingTool.resting(turn, position), holds, q)


def relocation_problems(grip: Grip) -> dict[str, RelocationProblem]:
    """From contact to contact; from the air to a contact; and one whose straight way is blocked."""
    robot, tool = grip.world.robot, grip.tool
    thumb, index, middle = (grip.holds[name] for name in ("thumb", "index", "middle"))
    place = grip.world.tool.place(NEXT_INDEX[0], np.radians(NEXT_INDEX[1]))
    there = Hold.at(robot, GRIP_AFTER, tool.oRtool, index.finger, place.point, place.normal)
    chain = ClosedChain(robot, (thumb, middle, there))
    moved = RelocationProblem(
        robot=robot,
        world=grip.world,
        holds=(thumb, middle),
        finger="index",
        start=grip.q,
        goal=project(chain, GRIP_AFTER, *tool.pose(0.0)).q,
        tool=tool,
        start_normal=index.normal,
        goal_normal=there.normal,
        options=RelocationOptions(time_limit_s=TIME_LIMIT_S),
    )
    airborne = []
    for posture in (LIFTED, CURLED):
        start = grip.q.copy()
        start[list(middle.finger.columns)] = posture
        airborne.append(
            replace(
                moved,
                holds=(thumb, index),
                finger="middle",
                start=start,
                goal=grip.q,
                start_normal=None,
                goal_normal=middle.normal,
            )
        )
    return {
        "index, contact to contact": moved,
        "middle, first contact": airborne[0],
        "middle, straight way blocked": airborne[1],
    }


def relocation_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Search times against OMPL's constrained RRT, and the engines' share.

    Same chain (9) with its Jacobian, same collision rule, same start, goal and time limit, after
    the retreats along the normals. Times are means over seeds; a failure counts the time limit.
    If OMPL is not installed, the peer's columns are empty and say so.
    """
    seeds = range(2 if quick else 5)
    rows = []
    problems = relocation_problems(knife_grip())
    for name, problem in problems.items():
        task = Task(problem)
        ours = [task.ours(seed) for seed in seeds]
        try:
            peer = [task.ompl(seed) for seed in seeds]
        except ImportError:
            peer = []
        rows.append(_row(f"relocation search: {name}", ours, "OMPL constrained RRT", peer))
    rows.append(_share(list(problems.values()), len(seeds)))
    return rows


class Task:
    """A relocation between the ends of its retreats, for any planner."""

    def __init__(self, problem: RelocationProblem) -> None:
        self.problem = problem
        self.manifold = Manifold(problem)
        self.validity = Validity(problem, self.manifold)
        ends = []
        for q, s, normal in (
            (problem.start, 0.0, problem.start_normal),
            (problem.goal, problem.s_goal, problem.goal_normal),
        ):
            way = retreat(problem, self.manifold, self.validity, q, s, normal)
            end = None if way is None else self.manifold.settle(way[-1], s, TOLERANCE)
            assert end is not None
            ends.append((end, s))
        self.ends = ends[0], ends[1]

    def ours(self, seed: int) -> float:
        """Time of our search [s], the limit if it failed."""
        rng = np.random.default_rng(seed)
        found = search(self.problem, self.manifold, self.validity, self.ends, rng)
        return found.time_s if found.outcome == "found" else TIME_LIMIT_S

    def ompl(self, seed: int) -> float:
        """Time of OMPL's RRT in a projected state space [s], the limit if it failed.

        Raises:
            ImportError: if OMPL is not installed.
        """
        from ompl import base, geometric, util

        util.setLogLevel(util.LogLevel.LOG_NONE)
        util.RNG.setSeed(seed + 1)  # of no effect after its first use
        robot, chain, pose = self.manifold.robot, self.manifold.chain, self.problem.tool.pose(0.0)
        lengths = chain.row_lengths()

        class Closed(base.Constraint):  # type: ignore[misc]
            def __init__(self) -> None:
                super().__init__(robot.nv, chain.rows, 1e-6)

            def function(self, q: Array, out: Array) -> None:
                chain.update(q, *pose)
                out[:] = chain.residual * lengths

            def jacobian(self, q: Array, out: Array) -> None:
                chain.update(q, *pose)
                out[:] = chain.jacobian * lengths[:, None]

        ambient, bounds = base.RealVectorStateSpace(robot.nv), base.RealVectorBounds(robot.nv)
        for k in range(robot.nv):
            bounds.setLow(k, float(robot.lower[k]))
            bounds.setHigh(k, float(robot.upper[k]))
        ambient.setBounds(bounds)
        constraint = Closed()
        space = base.ProjectedStateSpace(ambient, constraint)
        setup = geometric.SimpleSetup(base.ConstrainedSpaceInformation(space))

        def free(state: Any) -> bool:
            q = np.array([state[k] for k in range(robot.nv)])
            return robot.within_limits(q) and self.validity.free(q, 0.0)

        setup.setStateValidityChecker(free)
        states = [space.allocState() for _ in self.ends]
        for state, (q, _) in zip(states, self.ends, strict=True):
            state.copy(q.tolist())
        setup.setStartAndGoalStates(*states, 0.02)
        # Its own longest step: with shorter ones (0.2 to 1 rad) it did worse.
        setup.setPlanner(geometric.RRT(setup.getSpaceInformation()))
        setup.setup()
        began = perf_counter()
        setup.solve(TIME_LIMIT_S)
        spent = perf_counter() - began
        return spent if setup.haveExactSolutionPath() else TIME_LIMIT_S


def _row(name: str, ours: list[float], peer: str, others: list[float]) -> dict[str, Any]:
    mean = float(np.mean(ours))
    other = float(np.mean(others)) if others else None
    return {
        "name": name,
        "ours_s": mean,
        "peer": peer if others else f"{peer} (not installed: pip install ompl)",
        "peer_s": other,
        "ratio": None if other is None else other / mean,
        "solved": float(np.mean([t < TIME_LIMIT_S for t in ours])),
        "peer_solved": float(np.mean([t < TIME_LIMIT_S for t in others])) if others else None,
    }


def _share(problems: list[RelocationProblem], seeds: int) -> dict[str, Any]:
    """Share of whole relocations spent in Coal and Pinocchio."""
    began = perf_counter()
    with engine_time() as spent:
        for problem in problems:
            for seed in range(seeds):
                plan_relocation(problem, np.random.default_rng(seed))
    whole = perf_counter() - began
    share = spent() / whole
    return {
        "name": f"relocation, whole; {100.0 * share:.0f} % of it in Coal and Pinocchio",
        "ours_s": whole / (len(problems) * seeds),
        "peer": None,
        "peer_s": None,
        "ratio": None,
        "engine_share": share,
    }


ENGINE_CALLS = (
    "computeCollisions",
    "computeDistance",
    "computeDistances",
    "computeJointJacobians",
    "forwardKinematics",
    "getFrameClassicalAcceleration",
    "getFrameJacobian",
    "updateFramePlacement",
    "updateGeometryPlacements",
)


@contextmanager
def engine_time() -> Iterator[Callable[[], float]]:
    """Time spent in Pinocchio and, through it, in Coal [s], while the context lasts.

    The functions are replaced by timed ones, so that programs pay nothing at other times.
    """
    total = 0.0

    def timed(call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*args: Any, **options: Any) -> Any:
            nonlocal total
            began = perf_counter()
            try:
                return call(*args, **options)
            finally:
                total += perf_counter() - began

        return run

    plain = {name: getattr(pin, name) for name in ENGINE_CALLS}
    try:
        for name, call in plain.items():
            setattr(pin, name, timed(call))
        yield lambda: total
    finally:
        for name, call in plain.items():
            setattr(pin, name, call)
