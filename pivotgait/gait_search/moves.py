"""The moves there are from a state, judged by what costs microseconds: places and forces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.candidates import (
    Candidate,
    Candidates,
    by_finger,
    fingers_of,
    tip_centres,
)
from pivotgait.gait_search.cost import Cost, CostWeights
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.hand_reach import HandReach
from pivotgait.gait_search.order import FEWEST, Prices
from pivotgait.gait_search.removal_turns import RemovalTurns
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.static_tests import can_carry, grasp_depths
from pivotgait.gait_search.timing import HOVER_M, RETREAT_M, PhaseStyle
from pivotgait.models import LiftTarget, Scene

Branches = Branch[GraspState, Move]
LIFT_SAMPLES = 5
"""Attitudes of a lift at which its fingers must hold the tool."""
OTHER_PITCH = 4.0
"""What a lift to another pitch than the scene's own waits longer."""
LIFTED_BY = 2
"""Fingers that lift the tool: more are added while it rests on its pivot."""


@dataclass(frozen=True, eq=False)
class MoveOptions:
    """Which moves there are.

    Attributes:
        lifted_by: contacts of the first grasp; any two without it.
        pitches_deg: of lifts, besides the one of the scene's gaits [deg].
        carries: whether a grasp is to take the tool off the table; None if it stays on its pivot.
    """

    lifted_by: tuple[Candidate, ...] = ()
    pitches_deg: tuple[float, ...] = ()
    carries: Callable[[Mapping[str, Candidate]], bool] | None = None


class Moves:
    """Lifts, additions and removals, with estimates of what they cost.

    Args:
        scene: tool, table, hand.
        candidates: where fingers may hold.
        weights: of the cost.
        deaths: counts moves that cannot be made.
        options: which moves there are.
    """

    def __init__(
        self,
        scene: Scene,
        candidates: Candidates,
        weights: CostWeights,
        deaths: Deaths,
        options: MoveOptions | None = None,
    ) -> None:
        self.scene, self.weights, self.deaths = scene, weights, deaths
        self.style = PhaseStyle.of(scene)
        self._options = options or MoveOptions()
        self._by_finger = by_finger(fingers_of(scene), candidates)
        robot = scene.robot
        self._radii = {f.name: f.tip_radius for f in robot.fingers.values()} if robot else {}
        self._reach = None if robot is None else HandReach(robot, scene.clearance)
        self._turn = RemovalTurns(scene)

    def narrowed(self, candidates: Candidates, deaths: Deaths) -> Moves:
        """These moves with other candidates, judged more coarsely where that is enough.

        Args:
            candidates: where fingers may come.
            deaths: counts moves that cannot be made.
        """
        same = copy(self)
        same.deaths, same._by_finger = deaths, by_finger(self._by_finger, candidates)
        same._turn = RemovalTurns(self.scene, self.scene.lift_rotation(self.targets()[0]))
        return same

    @cached_property
    def lifts(self) -> tuple[Move, ...]:
        """Off the table, whatever the goal."""
        return tuple(self._lifts(self.start()))

    def start(self) -> GraspState:
        """The tool on the table."""
        return GraspState(self.scene.rest_rotation)

    def least(self, lifts: int, additions: int, removals: int, transfers: int = 0) -> float:
        """Cost of so many moves at least."""
        style = self.style
        lift_rad = min(self._lift_angle(target) for target in self.targets())
        cost = Cost(lifts * lift_rad, 0.0, 0.0, lifts * style.lift.duration_s)
        way = RETREAT_M if self.scene.robot else 0.0
        each = style.addition.duration_s + (style.relocation_s(way) if self.scene.robot else 0.0)
        cost += Cost(path_m=additions * way, time_s=additions * each)
        cost += Cost(time_s=removals * style.removal.duration_s)
        cost += Cost(time_s=transfers * style.transfer.duration_s)
        return cost.total(self.weights)

    @property
    def prices(self) -> Prices:
        """Least cost of a move of each kind."""
        kinds = np.eye(4, dtype=int).tolist()
        return Prices(*(self.least(*counts) for counts in kinds))

    def of(self, branch: Branches) -> Iterator[tuple[Move, GraspState, float]]:
        """Moves from a branch's state, the states after them and their costs."""
        state = branch.state
        moves = iter(self.lifts) if not state.held else self._changes(state)
        for move in moves:
            yield move, move.after, move.cost.total(self.weights)

    def prefer_own_lifts(self, branch: Branches) -> bool:
        """A lift to another pitch than that of the scene's gaits waits longer."""
        move = branch.move
        own = self.style.lift.to.pitch_deg
        if move is not None and move.target is not None and move.target.pitch_deg != own:
            branch.delay += OTHER_PITCH
        return True

    def settle_removal(self, branch: Branches) -> bool:
        """Look for the attitude in which the others hold the tool; turning it costs."""
        move, before = branch.move, branch.parent
        if move is None or before is None or move.kind != "removal":
            return True
        (leaving,) = move.contacts
        staying = [each for name, each in before.state.held.items() if name != leaving.finger]
        turn = self._turn(staying, before.state.rotation)
        if not turn.feasible:
            self.deaths.add("attitude after a removal", f"none without {leaving.finger}")
            return False
        depth = float(self._depths([staying], turn.rotation)[0])
        after = before.state.without_finger(leaving.finger, turn.rotation, depth)
        cost = move.cost + Cost(turn.angle, self.weights.shortfall(depth))
        branch.state, branch.move = after, Move("removal", move.contacts, after, cost)
        branch.cost = before.cost + cost.total(self.weights)
        return True

    def _lifts(self, state: GraspState) -> Iterator[Move]:
        targets = [each for each in self.targets() if self._clear_of_table(each)]
        for grasps in self._first_grasps(state.rotation):
            depths = self._depths(grasps, state.rotation, exact=False)
            self.deaths.add("forces at rest", "lift", int((depths < 0.0).sum()))
            good = [each for each, depth in zip(grasps, depths, strict=True) if depth >= 0.0]
            for target in targets:
                yield from self._lifts_to(target, state.rotation, good)

    def _clear_of_table(self, target: LiftTarget) -> bool:
        if float(self.scene.height(self.scene.lift_rotation(target))) >= self.scene.clearance:
            return True
        self.deaths.add("over the table", f"tool at a pitch of {target.pitch_deg:g} deg")
        return False

    def _lifts_to(
        self, target: LiftTarget, start: Rotation, grasps: Sequence[tuple[Candidate, ...]]
    ) -> Iterator[Move]:
        """Of grasps that hold the tool at the start."""
        end = self.scene.lift_rotation(target)
        way = Slerp([0.0, 1.0], Rotation.concatenate((start, end)))
        attitudes = way(np.linspace(0.0, 1.0, LIFT_SAMPLES)[1:])
        base = Cost(self._lift_angle(target), time_s=self.style.lift.duration_s)
        for held, depth in self._holding(grasps, attitudes):
            after = GraspState(
                end, MappingProxyType({each.finger: each for each in held}), depth_N=depth
            )
            cost = base + Cost(shortfall=self.weights.shortfall(depth))
            yield Move("lift", tuple(held), after, cost, target)

    def _first_grasps(self, rotation: Rotation) -> Iterator[list[tuple[Candidate, ...]]]:
        """Batches of grasps of the same fingers that the hand may take on the table."""
        if self._options.lifted_by:
            yield [self._options.lifted_by]
            return
        free = {name: self._over_table(each, rotation) for name, each in self._by_finger.items()}
        for one, other in combinations(free, LIFTED_BY):
            pairs = list(product(free[one], free[other]))
            if pairs:
                fits = self._apart([a for a, _ in pairs], [b for _, b in pairs])
                self.deaths.add("span of the hand", f"{one} and {other}", int((~fits).sum()))
                yield [pair for pair, fit in zip(pairs, fits, strict=True) if fit]

    def _holding(
        self, grasps: Sequence[tuple[Candidate, ...]], attitudes: Rotation
    ) -> Iterator[tuple[tuple[Candidate, ...], float]]:
        """Grasps that hold the tool in every attitude, and how far inside in the last."""
        alive = list(grasps)
        for place, attitude in enumerate(attitudes):
            last = place == len(attitudes) - 1
            depths = self._depths(alive, attitude, exact=last)
            self.deaths.add("forces at rest", "lift", int((depths < 0.0).sum()))
            alive = [each for each, depth in zip(alive, depths, strict=True) if depth >= 0.0]
        yield from zip(alive, depths[depths >= 0.0].tolist(), strict=True)

    def _changes(self, state: GraspState) -> Iterator[Move]:
        """Additions of free fingers, removals where enough others hold, the way off the table."""
        carries = self._options.carries
        if carries is not None and carries(state.held):
            yield from self._transfer(state)
        for finger in self._by_finger:
            if finger not in state.held:
                yield from self._additions(state, finger)
            elif len(state.held) > FEWEST:
                cost = Cost(time_s=self.style.removal.duration_s)
                after = state.without_finger(finger, state.rotation, state.depth_N)
                yield Move("removal", (state.held[finger],), after, cost)

    def _additions(self, state: GraspState, finger: str) -> Iterator[Move]:
        left = state.left.get(finger)
        there = [each for each in self._by_finger[finger] if left is None or each.name != left.name]
        there = self._over_table(there, state.rotation)
        for held in state.held.values():
            fits = self._apart(there, [held] * len(there))
            self.deaths.add("span of the hand", f"{finger} and {held.finger}", int((~fits).sum()))
            there = [each for each, fit in zip(there, fits, strict=True) if fit]
        depths = self._depths([[*state.held.values(), each] for each in there], state.rotation)
        self.deaths.add("forces at rest", f"addition of {finger}", int((depths < 0.0).sum()))
        for each, depth in zip(there, depths.tolist(), strict=True):
            if depth >= 0.0:
                cost = self._addition_cost(left, each, depth)
                yield Move("addition", (each,), state.with_finger(each, depth), cost)

    def _transfer(self, state: GraspState) -> Iterator[Move]:
        """Off the table, unless the weight turns the tool about the line through two fingers."""
        contacts = [each.contact for each in state.held.values()]
        if not can_carry(self.scene, contacts, state.rotation):
            self.deaths.add("forces at rest", "transfer")
            return
        after = replace(state, hanging=True)
        cost = Cost(time_s=self.style.transfer.duration_s)
        yield Move("transfer", tuple(state.held.values()), after, cost)

    def _addition_cost(self, left: Candidate | None, to: Candidate, depth: float) -> Cost:
        short, duration = self.weights.shortfall(depth), self.style.addition.duration_s
        if self.scene.robot is None:
            return Cost(shortfall=short, time_s=duration)
        way = HOVER_M
        if left is not None:
            way = RETREAT_M + float(np.linalg.norm(to.contact.point - left.contact.point))
        return Cost(0.0, short, way, duration + self.style.relocation_s(way))

    def _over_table(self, candidates: Sequence[Candidate], rotation: Rotation) -> list[Candidate]:
        """Those whose fingertip has room over the table."""
        centres = tip_centres(candidates, self._radii) @ rotation.as_matrix().T
        height = (centres + self.scene.centre_of_mass(rotation))[:, 2] - self.scene.table.height
        radius = np.array([self._radii.get(each.finger, 0.0) for each in candidates])
        free = height - radius >= self.scene.clearance
        self.deaths.add("over the table", "fingertip", int((~free).sum()))
        return [each for each, good in zip(candidates, free, strict=True) if good]

    def _apart(self, ones: Sequence[Candidate], others: Sequence[Candidate]) -> NDArray[np.bool_]:
        """(N,) whether the hand's tips can be as far apart as these contacts, and not nearer."""
        if self._reach is None or not ones:
            return np.ones(len(ones), dtype=bool)
        apart = tip_centres(ones, self._radii) - tip_centres(others, self._radii)
        distance = np.linalg.norm(apart, axis=1)
        return self._reach.admits(ones[0].finger, others[0].finger, distance)

    def _depths(
        self, grasps: Sequence[Sequence[Candidate]], rotation: Rotation, *, exact: bool = True
    ) -> Array:
        contacts = [[each.contact for each in grasp] for grasp in grasps]
        return grasp_depths(self.scene, contacts, rotation, exact=exact)

    def targets(self) -> list[LiftTarget]:
        """Attitudes in which lifts may end."""
        own = self.style.lift.to
        pitches = dict.fromkeys((own.pitch_deg, *self._options.pitches_deg))
        return [own.model_copy(update={"pitch_deg": pitch}) for pitch in pitches]

    def _lift_angle(self, target: LiftTarget) -> float:
        turn = self.scene.lift_rotation(target) * self.scene.rest_rotation.inv()
        return float(turn.magnitude())
