"""How often, and how fast, does the planner find a posture, and the way of a finger?

* **Postures** (inverse kinematics): contacts for two or three fingertips that some posture is
  known to reach. Random configurations of the arm-hand are drawn, uniformly within the joints'
  limits, until the fingertips could pinch something: a hub lies between them that each tip sees
  within its pad's cone. The tool is then a star of thin rods from the hub to the contacts, so that
  collisions of hand, arm, table and tool all count, as they do in a gait; the star itself may
  reach into the table. The drawn posture must keep every rule that the search keeps: limits,
  couplings, clearance, pads, conditioning. It is then forgotten. A problem is solved when the
  search finds any posture within its budget of starts and time.
* **Relocations**, all of a scene's gait: from the postures of one finished plan with many seeds
  of the planner; from many other postures; and, where the finger starts in the air, from random
  bends of it that touch nothing. The other postures come from the search for the whole gait's
  postures as it yields them; a plan keeps only postures whose relocations succeed, which would
  flatter the planner. Most attempts join start and goal without a single sample; how many do is
  told, since they say nothing about the random search. The benchmark's three problems stand
  beside, one of them with its straight way blocked.

Times are of one process on a machine that may have other work: CPU time stands beside wall time.
Failures count with the time they took.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.spatial.transform import Rotation
from scipy.stats import binomtest
from study_files import write_results

from pivotgait.benchmarks.relocation import knife_grip, relocation_problems
from pivotgait.contacts import contact_frame
from pivotgait.gaits import plan_gait
from pivotgait.gaits.itinerary import Itinerary, contacts_left
from pivotgait.gaits.steps import Step, plan_steps
from pivotgait.kinematics import ClosedChain, Hold, TaskJacobian, choose_palm_rows
from pivotgait.models import HandleContact, RelocationPhase, Robot, Scene, Tool, load_scene
from pivotgait.models.shape import Shape
from pivotgait.phases.grasp import Setting
from pivotgait.phases.relocation import relocation_problem
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_search import PostureOptions, PostureSearch
from pivotgait.planning.problem import RelocationOptions, RelocationProblem
from pivotgait.planning.relocation import plan_relocation
from pivotgait.plotting.planning_times import planning_times
from pivotgait.plotting.save import save_figure

Array = NDArray[np.float64]
SCENE = "knife"
GRASPS = {"thumb + index": ("thumb", "index"), "with middle": ("thumb", "index", "middle")}
HELD_M = (0.010, 0.080)
"""Thickness of what is pinched: distance of the thumb's contact from each other one."""
ROD_RADIUS_M = 0.002
BUDGET = PostureOptions(starts=100, time_limit_s=5.0)
TIME_LIMIT_S = 5.0
BENDS = 4
PLAN_SEED = 0
DRAW_SEED, SEARCH_SEED, POSTURE_SEED, BEND_SEED = 4, 1004, 2004, 3004


@dataclass(frozen=True, eq=False)
class Pinch:
    """Contacts that can be reached, and the posture that shows it.

    Attributes:
        world: with the star as the tool.
        key: the contacts; the tool frame is the world's with its origin at the hub.
        witness: (nv,) the posture drawn.
    """

    world: CollisionWorld
    key: KeyPose
    witness: Array


class Pinches:
    """Draws problems of inverse kinematics.

    Args:
        scene: with the arm-hand and the table.
        fingers: that touch; the thumb first.
        rng: source of randomness.

    Attributes:
        draws: what became of the configurations drawn so far, by rule.
    """

    def __init__(self, scene: Scene, fingers: Sequence[str], rng: np.random.Generator) -> None:
        assert scene.robot is not None
        self.scene, self.robot, self.fingers = scene, scene.robot, tuple(fingers)
        self.draws: Counter[str] = Counter()
        self._rng, self._data = rng, scene.robot.model.createData()

    def __iter__(self) -> Iterator[Pinch]:
        robot = self.robot
        while True:
            q = self._rng.uniform(robot.lower, robot.upper)
            pinch = self._pinch(q)
            self.draws[pinch if isinstance(pinch, str) else "kept"] += 1
            if isinstance(pinch, Pinch):
                yield pinch

    def _pinch(self, q: Array) -> Pinch | str:
        """The problem that a configuration solves, or the rule it breaks."""
        robot = self.robot
        if not robot.within_limits(q):
            return "coupling"
        pin.framesForwardKinematics(robot.model, self._data, q)
        tips = {name: self._data.oMf[robot.fingers[name].tip_frame_id] for name in self.fingers}
        hub = hub_of([tip.translation for tip in tips.values()])
        contacts, directions = {}, {}
        for name, tip in tips.items():
            finger = robot.fingers[name]
            inward = (hub - tip.translation) / np.linalg.norm(hub - tip.translation)
            directions[name] = tip.rotation.T @ inward
            if finger.pad @ directions[name] < np.cos(finger.pad_cone):
                return "pad"
            point = tip.translation + finger.tip_radius * inward - hub
            contacts[name] = HandleContact(f"{name}_contact", name, point, inward, 0.8, 0.3, 4.0)
        if not is_thick(contacts):
            return "thickness"
        scene, key = self.scene, KeyPose("pinch", np.eye(3), hub, contacts)
        tool = star(scene.tool, list(contacts.values()))
        world = CollisionWorld(robot, tool, scene.table.height, scene.clearance)
        if not world.holding(frozenset(contacts)).free(q, key.rotation, key.position):
            return "collision"
        if conditioning(robot, key, directions, q) < BUDGET.singular_value_min:
            return "singular"
        return Pinch(world, key, q)


def hub_of(tips: Sequence[Array]) -> Array:
    """(3,) halfway between the first fingertip and the mean of the others [m]."""
    return np.asarray(0.5 * (tips[0] + np.mean(tips[1:], axis=0)))


def is_thick(contacts: Mapping[str, HandleContact]) -> bool:
    """Whether the thumb's contact is as far from the others as a handle is thick.

    No rod may be shorter than it is thick, either.
    """
    thumb, *others = contacts.values()
    low, high = HELD_M
    return all(low <= np.linalg.norm(each.point - thumb.point) <= high for each in others) and all(
        -each.normal @ each.point >= 2.0 * ROD_RADIUS_M for each in contacts.values()
    )


def star(tool: Tool, contacts: Sequence[HandleContact]) -> Tool:
    """The tool with rods from its origin to the contacts instead of its shapes."""
    return replace(tool, shapes=tuple(rod(each) for each in contacts))


def rod(contact: HandleContact) -> Shape:
    """A capsule from the hub whose far end touches the contact."""
    reach = float(np.linalg.norm(contact.point))
    outward = contact.point / reach
    length = reach - ROD_RADIUS_M
    return Shape(
        contact.name,
        "capsule",
        (ROD_RADIUS_M, length),
        contact_frame(outward),
        0.5 * length * outward,
    )


def conditioning(robot: Robot, key: KeyPose, directions: Mapping[str, Array], q: Array) -> float:
    """Distance of the scaled task Jacobian H from singularity [m]."""
    holds = [
        Hold.of(robot.fingers[name], contact.point, contact.normal, directions[name])
        for name, contact in key.contacts.items()
    ]
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    palm = pin.updateFramePlacement(robot.model, data, robot.palm_frame_id).rotation
    task = TaskJacobian(robot, holds, palm_target=np.asarray(key.rotation.T @ palm))
    choice = choose_palm_rows(task, q, key.rotation, key.position)
    return float(choice.smallest_singular_value)


@dataclass(frozen=True)
class Search:
    """One problem of inverse kinematics and how it went.

    Attributes:
        found: whether a posture was found within the budget.
        wall_s: time spent, setting the search up included.
        cpu_s: the same of the processor.
        starts: tried.
        failures: reason -> starts that ended by it.
        miss_m: largest distance of a tip's centre from its place, NaN without a posture.
    """

    found: bool
    wall_s: float
    cpu_s: float
    starts: int
    failures: dict[str, int]
    miss_m: float

    @classmethod
    def run(cls, pinch: Pinch, seed: int) -> Search:
        """Search for the first posture."""
        wall, cpu = perf_counter(), process_time()
        robot, rng = pinch.world.robot, np.random.default_rng(seed)
        search = PostureSearch(robot, pinch.world, [pinch.key], rng, BUDGET)
        found = next(search.candidates(), None)
        spent = perf_counter() - wall, process_time() - cpu
        record, miss = search.record, np.nan if found is None else miss_of(pinch, found.q[0])
        return cls(found is not None, *spent, record.starts, dict(record.failures), miss)


def miss_of(pinch: Pinch, q: Array) -> float:
    """Largest distance of a tip's centre from its place at a contact [m]."""
    robot, key = pinch.world.robot, pinch.key
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    off = []
    for name, contact in key.contacts.items():
        finger = robot.fingers[name]
        place = key.position + contact.point - finger.tip_radius * contact.normal
        off.append(np.linalg.norm(data.oMf[finger.tip_frame_id].translation - place))
    return float(max(off))


@dataclass(frozen=True, eq=False)
class Case:
    """A relocation to plan.

    Attributes:
        name: of the gait's step.
        problem: with its start and goal.
    """

    name: str
    problem: RelocationProblem


class Relocations:
    """The relocations of a scene's first gait.

    Args:
        scene: with an arm-hand.
    """

    def __init__(self, scene: Scene) -> None:
        assert scene.robot is not None
        self.scene, self.robot = scene, scene.robot
        self.steps = plan_steps(Setting.of(scene), next(iter(scene.gaits.values())))
        self.world = CollisionWorld(scene.robot, scene.tool, scene.table.height, scene.clearance)
        self._left = dict(contacts_left(scene, self.steps))

    def planned(self, seed: int) -> list[Case]:
        """From the postures of a finished plan."""
        cases, plan = [], plan_gait(self.scene, seed=seed)
        for step, phase in zip(self.steps, plan.phases, strict=True):
            if isinstance(step.config, RelocationPhase):
                assert phase.robot is not None
                turn, (start, goal) = phase.tool.rotation[0], phase.robot.q[[0, -1]]
                oRtool, fingers = turn.as_matrix(), self.robot.fingers
                holds = [
                    Hold.at(self.robot, start, oRtool, fingers[name], each.point, each.normal)
                    for name, each in step.before.fingers.items()
                ]
                cases.append(self._case(step, turn, holds, start, goal))
        return cases

    def searched(self, count: int, seed: int) -> list[Case]:
        """From the first postures for the whole gait, whatever becomes of it."""
        itinerary, cases = Itinerary.of(self.scene, self.steps), []
        options = PostureOptions(starts=100 * count, time_limit_s=np.inf)
        rng = np.random.default_rng(seed)
        search = PostureSearch(self.robot, self.world, itinerary.keys, rng, options)
        for postures in islice(search.candidates(), count):
            for step, stops in zip(self.steps, itinerary.stops, strict=True):
                if isinstance(step.config, RelocationPhase):
                    held = step.before.fingers
                    holds = [postures.holds[name, c.name] for name, c in held.items()]
                    start, goal = postures.q[[stops[0].key, stops[-1].key]]
                    cases.append(self._case(step, step.before.rotation, holds, start, goal))
        return cases

    def scattered(self, cases: Sequence[Case], count: int, seed: int) -> list[Case]:
        """The cases that start in the air, from so many random bends of the finger each."""
        robot, rng, found = self.robot, np.random.default_rng(seed), []
        for case in cases:
            problem, bends = case.problem, 0
            if problem.start_normal is not None:
                continue
            columns = list(robot.fingers[problem.finger].columns)
            world, pose = self.world.holding(problem.holding), problem.tool.pose(0.0)
            while bends < count:
                q = np.array(problem.start)
                q[columns] = rng.uniform(robot.lower[columns], robot.upper[columns])
                if robot.within_limits(q) and world.free(q, *pose):
                    found.append(Case(case.name, replace(problem, start=q)))
                    bends += 1
        return found

    def _case(
        self, step: Step, turn: Rotation, holds: Sequence[Hold], start: Array, goal: Array
    ) -> Case:
        config = step.config
        assert isinstance(config, RelocationPhase)
        problem = relocation_problem(
            self.scene,
            self.world,
            turn,
            holds,
            self.scene.contacts[config.contact],
            start=start,
            goal=goal,
            left=self._left.get(step.name),
            options=RelocationOptions(time_limit_s=TIME_LIMIT_S, sample_s=config.sample_s),
        )
        return Case(step.name, problem)


@dataclass(frozen=True)
class Attempt:
    """One planned relocation; lengths and times are NaN without a path.

    Attributes:
        found: whether there is a trajectory.
        failure: which stage failed and what bound it.
        wall_s: time spent on all stages.
        cpu_s: the same of the processor.
        iterations: of the search.
        length_found_m: of the search's path, a bound on the motion of any shape.
        length_m: the same after shortcuts, with retreat and approach.
        duration_s: of the motion.
        drift_m: largest residual of the holds at the samples, angles times the tip's radius.
        drift_between_m: the same halfway between samples.
    """

    found: bool
    failure: str
    wall_s: float
    cpu_s: float
    iterations: int
    length_found_m: float = np.nan
    length_m: float = np.nan
    duration_s: float = np.nan
    drift_m: float = np.nan
    drift_between_m: float = np.nan

    @classmethod
    def run(cls, problem: RelocationProblem, seed: int) -> Attempt:
        """Plan once."""
        wall, cpu = perf_counter(), process_time()
        result = plan_relocation(problem, np.random.default_rng(seed))
        spent = perf_counter() - wall, process_time() - cpu
        facts = result.failure, *spent, result.iterations
        if result.trajectory is None:
            return cls(False, *facts)
        q, time = result.trajectory.q, result.trajectory.time
        return cls(
            True,
            *facts,
            result.length_found,
            result.length,
            float(time[-1] - time[0]),
            drift(problem, q),
            drift(problem, 0.5 * (q[:-1] + q[1:])),
        )

    @property
    def in_time(self) -> bool:
        """Whether it was found within the limit, all stages together."""
        return self.found and self.wall_s <= TIME_LIMIT_S


def drift(problem: RelocationProblem, q: Array) -> float:
    """Largest residual of the holds over configurations (N, nv) [m], the tool at rest."""
    chain, pose = ClosedChain(problem.robot, problem.holds), problem.tool.pose(0.0)
    largest = 0.0
    for each in q:
        chain.update(each, *pose)
        largest = max(largest, float(np.abs(chain.residual * chain.row_lengths()).max()))
    return largest


def share(solved: int, count: int) -> dict[str, Any]:
    """Solved problems with the 95 % confidence interval of their share (Wilson's score)."""
    interval = binomtest(solved, count).proportion_ci(method="wilson")
    return {
        "problems": count,
        "solved": solved,
        "share": solved / count,
        "interval_95": [float(interval.low), float(interval.high)],
    }


def spread(values: Sequence[float]) -> dict[str, float]:
    """Median, 95th percentile and largest of those that are finite; NaN of none."""
    known = np.array([each for each in values if np.isfinite(each)] or [np.nan])
    median, high = np.percentile(known, [50, 95])
    return {"median": float(median), "p95": float(high), "max": float(known.max())}


def summary_of_searches(runs: Sequence[Search], draws: Counter[str]) -> dict[str, Any]:
    """Figures of one grasp's problems."""
    failures = sum((Counter(run.failures) for run in runs), Counter())
    return {
        **share(sum(run.found for run in runs), len(runs)),
        "wall_s": spread([run.wall_s for run in runs]),
        "cpu_s": spread([run.cpu_s for run in runs]),
        "starts": spread([float(run.starts) for run in runs]),
        "miss_m": spread([run.miss_m for run in runs]),
        "starts_failed": dict(failures.most_common()),
        "draws": dict(draws.most_common()),
        "runs": [asdict(run) for run in runs],
    }


def summary_of_attempts(runs: Sequence[Attempt]) -> dict[str, Any]:
    """Figures of one relocation's attempts."""
    names = ("wall_s", "cpu_s", "iterations", "length_found_m", "length_m", "duration_s")
    drifts = ("drift_m", "drift_between_m")
    return {
        **share(sum(run.in_time for run in runs), len(runs)),
        "found": sum(run.found for run in runs),
        "found_without_samples": sum(run.found and not run.iterations for run in runs),
        "failures": dict(Counter(run.failure for run in runs if run.failure).most_common()),
        **{name: spread([getattr(run, name) for run in runs]) for name in (*names, *drifts)},
        "runs": [asdict(run) for run in runs],
    }


def main(quick: bool = False, out: Path = Path("reports/out/analysis/04")) -> dict[str, Any]:
    """Run the study; write ``times`` as PDF and PNG, ``success.json`` into ``out``.

    Args:
        quick: 10 and 5 pinches instead of 200 and 100, 2 seeds and 2 postures instead of 50.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, began = Console(markup=False), perf_counter()
    scene = load_scene(SCENE)
    counts = (10, 5) if quick else (200, 100)
    searches: dict[str, dict[str, Any]] = {}
    for (name, fingers), count in zip(GRASPS.items(), counts, strict=True):
        pinches = Pinches(scene, fingers, np.random.default_rng(DRAW_SEED))
        problems = track(islice(pinches, count), name, count, console=console, transient=True)
        runs = [Search.run(pinch, SEARCH_SEED + k) for k, pinch in enumerate(problems)]
        searches[name] = summary_of_searches(runs, pinches.draws)
    count = 2 if quick else 50
    relocations = Relocations(scene)
    planned = relocations.planned(PLAN_SEED)
    other = relocations.searched(count, POSTURE_SEED)
    bent = relocations.scattered(other, 1 if quick else BENDS, BEND_SEED)
    bench = [Case(name, each) for name, each in relocation_problems(knife_grip()).items()]
    every = {
        "one plan": [(case, seed) for case in planned for seed in range(count)],
        "other postures": numbered(other),
        "random bends": numbered(bent),
        "benchmark": [(case, seed) for case in bench for seed in range(count)],
    }
    attempts: dict[str, dict[str, list[Attempt]]] = {}
    for name, cases in every.items():
        attempts[name] = {}
        for case, seed in track(cases, name, console=console, transient=True):
            done = attempts[name].setdefault(case.name, [])
            done.append(Attempt.run(case.problem, seed))
    result = {
        "scene": SCENE,
        "postures": {
            "budget": {"starts": BUDGET.starts, "time_limit_s": BUDGET.time_limit_s},
            "grasps": searches,
        },
        "relocations": {
            "time_limit_s": TIME_LIMIT_S,
            "plan_seed": PLAN_SEED,
            "sets": {
                name: {step: summary_of_attempts(runs) for step, runs in each.items()}
                for name, each in attempts.items()
            },
        },
    }
    save_figure(planning_times(panels(result), limit_s=TIME_LIMIT_S), out, "times")
    target = out / "success.json"
    write_results(target, result)
    tell(console, result)
    console.print(f"{out}: {perf_counter() - began:.0f} s")
    return result


def numbered(cases: Sequence[Case]) -> list[tuple[Case, int]]:
    """Cases with a seed of its own for each."""
    return [(case, seed) for seed, case in enumerate(cases)]


def panels(result: Mapping[str, Any]) -> dict[str, dict[str, Array]]:
    """Wall times for the figure, infinite where nothing was found."""

    def times(summary: Mapping[str, Any]) -> Array:
        return np.array([r["wall_s"] if r["found"] else np.inf for r in summary["runs"]])

    postures = {name: times(each) for name, each in result["postures"]["grasps"].items()}
    # One plan's attempts differ in nothing but the machine's noise if all are joined at once.
    relocations = {
        f"{step}, {name}": times(each)
        for name, steps in result["relocations"]["sets"].items()
        for step, each in steps.items()
        if name in ("other postures", "random bends")
    }
    blocked = {
        name: times(each) for name, each in result["relocations"]["sets"]["benchmark"].items()
    }
    return {
        "posture for given contacts": postures,
        "relocation": relocations,
        "relocation, benchmark": blocked,
    }


def tell(console: Console, result: Mapping[str, Any]) -> None:
    """Print both tables and what failed."""
    budget, grasps = result["postures"]["budget"], result["postures"]["grasps"]
    title = f"Postures, at most {budget['starts']} starts and {budget['time_limit_s']:g} s"
    rows = {"wall [s]": "wall_s", "CPU [s]": "cpu_s", "starts": "starts", "miss [m]": "miss_m"}
    console.print(filled(title, grasps, rows))
    for name, each in grasps.items():
        console.print(f"{name}: starts failed by {listed(each['starts_failed'])}")
        console.print(f"{name}: configurations drawn {listed(each['draws'])}")
    rows = {
        "wall [s]": "wall_s",
        "CPU [s]": "cpu_s",
        "samples": "iterations",
        "search's path [m]": "length_found_m",
        "whole path [m]": "length_m",
        "motion [s]": "duration_s",
        "drift [m]": "drift_m",
        "between [m]": "drift_between_m",
    }
    limit = result["relocations"]["time_limit_s"]
    for name, steps in result["relocations"]["sets"].items():
        console.print(filled(f"Relocations within {limit:g} s: {name}", steps, rows))
        for step, each in steps.items():
            direct = f"{each['found_without_samples']} of {each['problems']} without a sample"
            console.print(f"{step}: {direct}; failed by {listed(each['failures'])}")
    console.print("Median / 95th percentile over all problems; of paths where there is one.")
    console.print("Whole paths are after shortcuts, with the ways along the normals at both ends.")


def filled(title: str, columns: Mapping[str, Any], rows: Mapping[str, str]) -> Table:
    """A table of summaries: share solved, then median / 95th percentile of each quantity."""
    table = Table(title=title)
    for head in ("", *columns):
        table.add_column(head, justify="right")
    each = columns.values()
    table.add_row("solved", *(f"{c['solved']} / {c['problems']}" for c in each))
    table.add_row("95 %", *("{:.1%}-{:.1%}".format(*c["interval_95"]) for c in each))
    for name, key in rows.items():
        table.add_row(name, *(f"{c[key]['median']:.2g} / {c[key]['p95']:.2g}" for c in each))
    return table


def listed(counts: Mapping[str, int]) -> str:
    """Counts as text."""
    return ", ".join(f"{name} {count}" for name, count in counts.items()) or "none"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few problems and seeds")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis/04"))
    given = parser.parse_args()
    main(given.quick, given.out)
