"""From a tool and a wanted grasp to a sequence of gaits: contacts and their order are found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.gait_search.best_first import BestFirst, Check, Graph
from pivotgait.gait_search.candidates import Candidate, handle_candidates
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.found_scene import found_scene
from pivotgait.gait_search.full_plan import FoundGait, plan_fully
from pivotgait.gait_search.goals import Goal, estimate_moves
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.hand_fit import HandFit
from pivotgait.gait_search.lift_postures import LiftPostures
from pivotgait.gait_search.moves import LIFTED_BY, MoveOptions, Moves
from pivotgait.gait_search.notes import Branches, notes_of
from pivotgait.gait_search.order import Order
from pivotgait.gait_search.order_by_forces import order_by_forces
from pivotgait.gait_search.prefix_postures import PrefixPostures
from pivotgait.gait_search.rollout import Rollout
from pivotgait.gait_search.search_result import Ended, News, SearchOptions, SearchResult
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.models import Scene
from pivotgait.planning.posture_search import PostureOptions


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
    after a removal, the rest of the sequence by forces alone, the hand's postures for everything
    so far and to come, and for a whole sequence the planners of all phases and the certificate.

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
        early: list[Check[GraspState, Move]] = [self.moves.prefer_own_lifts]
        forces: list[Check[GraspState, Move]] = [self.moves.settle_removal]
        hand: list[Check[GraspState, Move]] = []
        self.order: Order | None = None
        if goal.contacts:
            self.order = order_by_forces(self.moves, goal)
            rollout = Rollout(self.moves, goal, self.order, options.inflation)
            early.append(rollout.prefer_known)
            forces.append(rollout.check)
        self.postures: PrefixPostures | None = None
        self.guidance: Guidance | None = None
        if (robot := self.scene.robot) is not None:
            attitude = self.scene.lift_rotation(self.moves.targets()[0])
            rng = np.random.default_rng(seed)
            guidance = Guidance(self.scene, robot, goal, attitude, rng)
            starts = PostureOptions(starts=options.starts, time_limit_s=np.inf)
            fit = HandFit(self.scene, robot, starts, seed)
            lifts = LiftPostures(self.scene, fit, guidance)
            postures = PrefixPostures(self.scene, fit, goal, self.deaths, guidance)
            early.append(lifts.expect)
            hand = [lifts.alone, postures.quick, postures.thorough, postures.roomy]
            self.guidance, self.postures = guidance, postures
        graph = Graph[GraspState, Move](
            key=lambda state: state.key,
            moves=self.moves.of,
            estimate=self.estimate,
            reached=lambda state: goal.reached(state.held) and state.hanging == goal.lifted_off,
            checks=[*early, *forces, *hand],
        )
        self.search = BestFirst(
            graph, self.moves.start(), inflation=options.inflation, visits=options.visits
        )

    def run(self, tell: Callable[[News], None]) -> SearchResult:
        """Until enough sequences are found or nothing is left."""
        found: list[FoundGait] = []
        ended: Ended = "exhausted"
        if self.order is not None and not self.order.possible:
            ended = "impossible"
            self.deaths.add("order of fingers", self.order.binding)
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
        return self.least(state) + (self.guidance.rank(state.held) if self.guidance else 0.0)

    def least(self, state: GraspState) -> float:
        """Least cost from a state to the goal."""
        if self.order:
            return self.order.rest(state.held, hanging=state.hanging)
        lifts, missing = estimate_moves(self.goal, state, LIFTED_BY)
        transfers = int(self.goal.lifted_off and not state.hanging)
        return self.moves.least(lifts, missing.additions, missing.removals, transfers)

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
            postures=_postures(path),
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


def _postures(path: list[Branches]) -> list[Array]:
    """The hand at the key poses of each move; none without a hand."""
    known = [each for each in (notes_of(branch).prefix for branch in path) if each is not None]
    if not known:
        return []
    return np.split(np.asarray(known[-1].q[: known[-1].done]), [each.done for each in known[:-1]])


def _middle_posture(path: list[Branches]) -> Array | None:
    """The posture at the key pose with the most contacts, the first of them."""
    prefix = notes_of(path[-1]).prefix
    if prefix is None:
        return None
    most = max(range(len(prefix.keys)), key=lambda k: len(prefix.keys[k].contacts))
    return np.asarray(prefix.q[most])
