"""From a tool and a wanted grasp to a sequence of gaits: contacts and their order are found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import Literal

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.gait_search.best_first import BestFirst, Branch, Graph
from pivotgait.gait_search.candidates import Candidate, CandidateOptions, handle_candidates
from pivotgait.gait_search.cost import CostWeights
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.found_scene import found_scene
from pivotgait.gait_search.full_plan import FoundGait, plan_fully
from pivotgait.gait_search.goals import Goal, estimate_moves
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.moves import LIFTED_BY, MoveOptions, Moves
from pivotgait.gait_search.prefix_postures import Prefix, PrefixPostures
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.models import Scene

Ended = Literal["found", "exhausted", "time", "plans"]
Branches = Branch[GraspState, Move]


@dataclass(frozen=True)
class SearchOptions:
    """How to search.

    Attributes:
        weights: of the cost.
        candidates: how densely the handle is covered.
        pitches_deg: of lifts, besides the one of the scene's gaits [deg].
        inflation: of the estimate of the rest; above 1 the search is greedier.
        visits: times a grasp may be left on different paths: postures depend on the path.
        starts: random starts of the postures of each branch.
        plan_starts: starts of the postures of a whole plan.
        plans: most sequences that are planned fully.
        sequences: certified ones to find, of which the cheapest as measured is taken.
        time_limit_s: no branch is looked at after this time [s].
        hand: whether the scene's robot is asked; else the tool and its forces alone.
    """

    weights: CostWeights = field(default_factory=CostWeights)
    candidates: CandidateOptions = field(default_factory=CandidateOptions)
    pitches_deg: tuple[float, ...] = ()
    inflation: float = 2.0
    visits: int = 3
    starts: int = 5
    plan_starts: int = 24
    plans: int = 20
    sequences: int = 1
    time_limit_s: float = 60.0
    hand: bool = True

    def __post_init__(self) -> None:
        for name in ("inflation", "visits", "starts", "plan_starts", "plans", "sequences"):
            if not 1 <= getattr(self, name) < np.inf:
                raise InputError(f"is {getattr(self, name)}", where=name, mend="give 1 or more")
        if not self.time_limit_s > 0.0:
            mend = "give a time above 0, in seconds"
            raise InputError(f"is {self.time_limit_s}", where="time_limit_s", mend=mend)


@dataclass(frozen=True)
class News:
    """How far a search has come.

    Attributes:
        expanded: branches whose moves were looked at.
        waiting: branches.
        postures: branches whose postures were sought.
        plans: sequences planned fully.
        dead: branches and moves that died.
    """

    expanded: int
    waiting: int
    postures: int
    plans: int
    dead: int


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What came of a search; nothing found is a result too.

    Attributes:
        goal: as the user named it.
        found: the cheapest certified sequence, None if there is none.
        others: further certified ones.
        ended: by what.
        news: how far it came.
        deaths: why branches died.
        elapsed_s: time spent [s].
    """

    goal: str
    found: FoundGait | None
    others: tuple[FoundGait, ...]
    ended: Ended
    news: News
    deaths: Deaths
    elapsed_s: float


def search_gait(
    scene: Scene,
    goal: Goal,
    *,
    seed: int = 0,
    first: tuple[Candidate, ...] = (),
    name: str | None = None,
    options: SearchOptions | None = None,
    folder: Path | None = None,
    tell: Callable[[News], None] | None = None,
) -> SearchResult:
    """Find contacts and the order of gaits that lead to a wanted grasp.

    Branches wait in the order of their cost and an estimate of the rest (A*). One that comes
    first is looked at more closely, step by step: forces at rest when it is made, the attitude
    after a removal, the hand's postures for everything so far, and for a whole sequence the
    planners of all phases and the certificate.

    Args:
        scene: tool on the table, hand, limits; its gaits give the timing of phases and the
            attitude after the lift.
        goal: wanted grasp.
        seed: of postures and plans; the same one gives the same answer unless time runs out.
        first: contacts that lift the tool; any two without them.
        name: of the found scene; the scene's name and ``_found`` without it.
        options: how to search.
        folder: in which relative URDF paths of the scene start.
        tell: called as the search goes on.

    Raises:
        InputError: a negative seed.
    """
    if seed < 0:
        raise InputError(f"seed {seed} is negative", where="seed", mend="give 0 or more")
    return _Search(scene, goal, seed, first, name, options or SearchOptions(), folder).run(
        tell or (lambda news: None)
    )


class _Search:
    def __init__(
        self,
        scene: Scene,
        goal: Goal,
        seed: int,
        first: tuple[Candidate, ...],
        name: str | None,
        options: SearchOptions,
        folder: Path | None,
    ) -> None:
        self.began = perf_counter()
        self.goal, self.seed, self.options, self.folder = goal, seed, options, folder
        self.scene = scene if options.hand else without_robot(scene)
        self.name = name or f"{scene.name}_found"
        self.deaths, self.planned = Deaths(), 0
        lost: Counter[str] = Counter()
        candidates = dict(handle_candidates(self.scene, options.candidates, lost))
        for reason, number in lost.items():
            self.deaths.add("place on the handle", reason, number)
        candidates.update({**goal.contacts, **{each.name: each for each in first}})
        self.moves = Moves(
            self.scene,
            MappingProxyType(candidates),
            options.weights,
            self.deaths,
            MoveOptions(first, options.pitches_deg, goal.reached if goal.lifted_off else None),
        )
        self.postures: PrefixPostures | None = None
        self.guidance: Guidance | None = None
        if (robot := self.scene.robot) is not None:
            attitude = self.scene.lift_rotation(self.moves.targets()[0])
            rng = np.random.default_rng(seed)
            self.guidance = Guidance(self.scene, robot, goal, attitude, rng)
            self.postures = PrefixPostures(
                self.scene, robot, goal, self.deaths, self.guidance, seed, options.starts
            )
        checks = [self.moves.settle_removal]
        graph = Graph[GraspState, Move](
            key=lambda state: state.key,
            moves=self.moves.of,
            estimate=self.estimate,
            reached=lambda state: goal.reached(state.held) and state.hanging == goal.lifted_off,
            checks=[*checks, self.postures.check] if self.postures else checks,
        )
        self.search = BestFirst(
            graph, self.moves.start(), inflation=options.inflation, visits=options.visits
        )

    def run(self, tell: Callable[[News], None]) -> SearchResult:
        """Until enough sequences are found or nothing is left."""
        found: list[FoundGait] = []
        ended: Ended = "exhausted"
        for branch in self.search.steps():
            if branch is not None and (gait := self.plan(branch)) is not None:
                found.append(gait)
            tell(self.news())
            if len(found) == self.options.sequences:
                ended = "found"
                break
            if self.planned == self.options.plans:
                ended = "plans"
                break
            if perf_counter() - self.began > self.options.time_limit_s:
                ended = "time"
                break
        weights = self.options.weights
        found.sort(key=lambda gait: gait.cost.total(weights))
        elapsed = perf_counter() - self.began
        return SearchResult(
            self.goal.text,
            found[0] if found else None,
            tuple(found[1:]),
            "found" if found else ended,
            self.news(),
            self.deaths,
            elapsed,
        )

    def estimate(self, state: GraspState) -> float:
        """Least cost from a state to the goal, and what the hand's distance from it adds."""
        lifts, missing = estimate_moves(self.goal, state, LIFTED_BY)
        transfers = int(self.goal.lifted_off and not state.hanging)
        least = self.moves.least(lifts, missing.additions, missing.removals, transfers)
        return least + (self.guidance.rank(state.held) if self.guidance else 0.0)

    def plan(self, branch: Branches) -> FoundGait | None:
        """Plan a branch's sequence fully; if that fails, bury what cannot be done."""
        self.planned += 1
        path = branch.path()
        moves = [each.move for each in path if each.move is not None]
        steps = "; ".join(move.name for move in moves)
        found = found_scene(
            self.scene,
            moves,
            name=self.name,
            description=f"Found for the goal '{self.goal.text}': {steps}.",
            comment=(
                f"Found by: pivotgait search {self.scene.name} --goal '{self.goal.text}' "
                f"--seed {self.seed}"
            ),
            home=_middle_posture(path),
            folder=self.folder,
        )
        options = self.options
        result = plan_fully(
            found,
            moves,
            self.goal,
            options.weights,
            seed=self.seed,
            starts=options.plan_starts,
        )
        if isinstance(result, FoundGait):
            return result
        self.deaths.add(result.stage, result.reason)
        path[result.move].dead = True
        return None

    def news(self) -> News:
        """How far the search has come."""
        tried = self.postures.tried if self.postures else 0
        search = self.search
        return News(search.expanded, search.waiting, tried, self.planned, self.deaths.total)


def without_robot(scene: Scene) -> Scene:
    """The scene as its tool feels it."""
    config = scene.config.model_copy(update={"robot": None})
    return replace(scene, config=config, robot=None)


def _middle_posture(path: list[Branches]) -> Array | None:
    """The posture at the key pose with the most contacts, the first of them."""
    prefix = path[-1].notes
    if not isinstance(prefix, Prefix):
        return None
    most = max(range(len(prefix.keys)), key=lambda k: len(prefix.keys[k].contacts))
    return np.asarray(prefix.q[most])
