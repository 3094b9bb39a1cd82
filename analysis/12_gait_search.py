"""Does the search find gaits from the goal alone, how fast, and why not where it does not?

* **Named goals**: the grasps in which the built-in scenes' own gaits end, searched from the goal
  alone. What the scene's own sequence costs in the same terms stands beside; contacts and order
  of the gaits are not told to the search.
* **Random goals on the knife**: places for thumb, index and middle, uniform along and around the
  handle. Kept are those whose forces hold the tool in the lifted attitude and for which the hand
  has a posture there, collisions included: a grasp that cannot be held, whatever leads to it, is
  no question to a planner of gaits. What was drawn and not kept is counted by its reason.

Times are wall time of one process, everything included: candidates, search, plan, certificate.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.stats import binomtest
from study_files import run_from_command_line, write_results

from pivotgait.exceptions import PivotGaitError, SceneError
from pivotgait.gait_search import (
    Candidate,
    Goal,
    NamedGrasp,
    SearchOptions,
    SearchResult,
    candidate_at,
    read_goal,
    search_gait,
)
from pivotgait.gait_search.candidates import tip_centres
from pivotgait.gait_search.deaths import STAGES
from pivotgait.gait_search.full_plan import measured_cost
from pivotgait.gait_search.hand_reach import HandReach
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.gaits import plan_gait
from pivotgait.models import LiftPhase, Scene, load_scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_search import PostureOptions, PostureSearch
from pivotgait.plotting.planning_times import planning_times
from pivotgait.plotting.save import save_figure

NAMED = {
    "knife": "thumb_spine, middle_flat, index_edge_near",
    "screwdriver": "lifted off by thumb_top and middle_below",
    "wrench": "thumb_side, middle_below, index_side_near",
    "spatula": "thumb_side, middle_side, index_side_near",
    "table_knife": "thumb_spine, middle_edge, index_edge_near",
}
FINGERS = ("thumb", "index", "middle")
GOALS, QUICK_GOALS = 20, 2
DRAW_SEED, SEARCH_SEED = 2026, 0
WITNESS_STARTS = 40
TIME_LIMIT_S = 60.0


class Draws:
    """Random grasps of the knife that can be held.

    Args:
        scene: with a hand.
        rng: source of randomness.

    Attributes:
        counts: what became of the grasps drawn so far, by rule.
    """

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        assert scene.robot is not None
        self.scene, self.robot, self._rng = scene, scene.robot, rng
        self.counts: Counter[str] = Counter()
        (lift,) = (p for gait in scene.gaits.values() for p in gait if isinstance(p, LiftPhase))
        self.lifted = scene.lift_rotation(lift.to)
        self._world = CollisionWorld(scene.robot, scene.tool, scene.table.height, scene.clearance)
        self._spans = HandReach(scene.robot, scene.clearance)

    def __iter__(self) -> Iterator[NamedGrasp]:
        while True:
            grasp = self._draw()
            self.counts[grasp if isinstance(grasp, str) else "kept"] += 1
            if not isinstance(grasp, str):
                text = ", ".join(f"{c.finger}@{c.along_m:g}/{c.around_deg:g}" for c in grasp)
                yield NamedGrasp(text, {each.name: each for each in grasp})

    def _draw(self) -> list[Candidate] | str:
        """A grasp, or the rule it breaks."""
        low, high = self.scene.tool.handle.extent
        grasp = []
        for finger in FINGERS:
            along = round(float(self._rng.uniform(low, high)), 3)
            around = round(float(self._rng.uniform(0.0, 360.0)))
            try:
                grasp.append(candidate_at(self.scene, finger, (along, around), where="draw"))
            except SceneError:
                return "place on an edge"
        if not self._reachable(grasp):
            return "tips too far apart or too near"
        contacts = [each.contact for each in grasp]
        if grasp_depths(self.scene, [contacts], self.lifted)[0] < 0.0:
            return "forces"
        if not self._has_posture(grasp):
            return "no posture of the hand"
        return grasp

    def _reachable(self, grasp: Sequence[Candidate]) -> bool:
        tips = tip_centres(grasp, {f.name: f.tip_radius for f in self.robot.fingers.values()})
        apart = [(i, k) for k in range(len(grasp)) for i in range(k)]
        return all(
            self._spans.admits(grasp[i].finger, grasp[k].finger, np.linalg.norm(tips[i] - tips[k]))
            for i, k in apart
        )

    def _has_posture(self, grasp: Sequence[Candidate]) -> bool:
        contacts = {each.finger: each.contact for each in grasp}
        place = self.scene.centre_of_mass(self.lifted)
        key = KeyPose("goal", self.lifted.as_matrix(), place, contacts)
        options = PostureOptions(starts=WITNESS_STARTS, time_limit_s=np.inf)
        search = PostureSearch(self.robot, self._world, [key], self._rng, options)
        return next(search.candidates(), None) is not None


def main(quick: bool = False, out: Path | None = None, workers: int = 1) -> dict[str, Any]:
    """Search for all goals; write ``gait_search.json`` and a figure into ``out``.

    Args:
        quick: the knife's named goal and two random ones.
        out: folder, made if missing; nothing is written without one.
        workers: searches at a time.

    Returns:
        What was written.
    """
    scenes = {name: load_scene(name) for name in (["knife"] if quick else NAMED)}
    named = {
        name: {**run(scene, read_goal(NAMED[name], scene)), "own": own_cost(scene)}
        for name, scene in track(scenes.items(), description="named goals", transient=True)
    }
    draws = Draws(scenes["knife"], np.random.default_rng(DRAW_SEED))
    goals = list(islice(draws, QUICK_GOALS if quick else GOALS))
    searches = (delayed(run_text)("knife", goal.text) for goal in goals)
    runs = list(Parallel(n_jobs=workers, verbose=10)(searches))
    result = {
        "named": named,
        "random": {**summary(runs), "draws": dict(draws.counts), "runs": runs},
    }
    tell(result)
    if out is not None:
        write_results(out / "gait_search.json", result)
        times = np.array([r["elapsed_s"] if r["solved"] else np.inf for r in runs])
        figure = planning_times({"knife": {"random goal grasps": times}}, limit_s=TIME_LIMIT_S)
        save_figure(figure, out, "gait_search")
    return result


def run_text(scene: str, goal: str) -> dict[str, Any]:
    """One search, of names alone, which other processes understand."""
    loaded = load_scene(scene)
    return run(loaded, read_goal(goal, loaded))


def run(scene: Scene, goal: Goal) -> dict[str, Any]:
    """One search."""
    options = SearchOptions(time_limit_s=TIME_LIMIT_S)
    result = search_gait(scene, goal, seed=SEARCH_SEED, options=options)
    found, weights = result.found, options.weights
    return {
        "goal": goal.text,
        "solved": found is not None,
        "reason": "" if found else reason(result),
        "elapsed_s": result.elapsed_s,
        "moves": [move.name for move in found.moves] if found else [],
        "cost": found.cost.as_json(weights) if found else None,
        "plans": result.news.plans,
        "postures": result.news.postures,
        "expanded": result.news.expanded,
        "deaths": result.deaths.as_json(),
    }


def reason(result: SearchResult) -> str:
    """How a search ended, and what killed most branches in the dearest test that any came to."""
    stage, most, _ = max(result.deaths.rows(), key=_dearest)
    return f"{result.ended}; {stage}: {most}"


def _dearest(row: tuple[str, str, int]) -> tuple[int, int]:
    return STAGES.index(row[0]), row[2]


def own_cost(scene: Scene) -> dict[str, float] | str:
    """What the scene's own gait costs in the search's terms, or why it cannot be planned."""
    weights = SearchOptions().weights
    try:
        plan = plan_gait(scene, seed=SEARCH_SEED)
    except PivotGaitError as error:
        return str(error)
    return measured_cost(scene, plan, weights).as_json(weights)


def summary(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Counts, their interval, times, and reasons of the failures."""
    solved = [each for each in runs if each["solved"]]
    interval = binomtest(len(solved), len(runs)).proportion_ci(method="wilson")
    times = [each["elapsed_s"] for each in runs]
    return {
        "goals": len(runs),
        "solved": len(solved),
        "wilson_95": [float(interval.low), float(interval.high)],
        "elapsed_s": {"median": float(np.median(times)), "max": float(np.max(times))},
        "failures": dict(Counter(each["reason"] for each in runs if not each["solved"])),
    }


def tell(result: Mapping[str, Any]) -> None:
    """Print the tables."""
    console = Console()
    table = Table("goal", "time", "sequence", "cost", "own gait's cost", title="named goals")
    for name, each in result["named"].items():
        own = each["own"]
        table.add_row(
            f"{name}: {each['goal']}",
            f"{each['elapsed_s']:.1f} s",
            "; ".join(each["moves"]) or each["reason"],
            f"{each['cost']['total']:.2f}" if each["cost"] else "-",
            own if isinstance(own, str) else f"{own['total']:.2f}",
        )
    console.print(table)
    table = Table("goal", "time", "sequence", "cost", title="random goals on the knife")
    for each in result["random"]["runs"]:
        cost = f"{each['cost']['total']:.2f}" if each["cost"] else "-"
        sequence = "; ".join(each["moves"]) or each["reason"]
        table.add_row(each["goal"], f"{each['elapsed_s']:.1f} s", sequence, cost)
    console.print(table)
    total = result["random"]
    console.print(
        f"{total['solved']} of {total['goals']} solved (95 %: {total['wilson_95'][0]:.2f} to "
        f"{total['wilson_95'][1]:.2f}), median {total['elapsed_s']['median']:.1f} s, longest "
        f"{total['elapsed_s']['max']:.1f} s; draws: {total['draws']}; failures: "
        f"{total['failures']}"
    )


if __name__ == "__main__":
    workers = {"type": int, "default": 1, "help": "searches at a time"}
    run_from_command_line(main, __doc__, Path("reports/out/analysis"), workers=workers)
