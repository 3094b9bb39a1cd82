"""Postures of the hand for all of a branch so far: dearer than forces, cheaper than a plan."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.gait_search.best_first import Branch
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.palm import PalmDistance
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.timing import STAND_OFF_M
from pivotgait.models import Robot, Scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_search import PostureOptions, PostureSearch


@dataclass(frozen=True, eq=False)
class Prefix(FrozenArrays):
    """A branch's key poses so far and postures for them.

    Attributes:
        keys: in the order of time.
        q: (K, nv).
    """

    keys: tuple[KeyPose, ...]
    q: Array


class PrefixPostures:
    """Tests whether the hand has postures for a branch.

    Args:
        scene: with a robot.
        robot: of the scene.
        goal: of the search; says how near the palm must be in the end.
        deaths: counts branches without postures.
        guidance: postures at the goal, from which each branch is tried, too.
        seed: of the starts; the same seed gives the same postures.
        starts: most random starts for a branch.

    Attributes:
        tried: number of branches tested.
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        goal: Goal,
        deaths: Deaths,
        guidance: Guidance,
        seed: int,
        starts: int,
    ) -> None:
        self._scene, self._robot, self._goal, self._deaths = scene, robot, goal, deaths
        self._guidance = guidance
        self._seed, self._options = seed, PostureOptions(starts=starts, time_limit_s=np.inf)
        self._world = CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)
        self._palm = PalmDistance(robot, scene.tool)
        self.tried = 0

    def check(self, branch: Branch[GraspState, Move]) -> bool:
        """Whether there are postures; they become the branch's notes."""
        parent, move = branch.parent, branch.move
        if parent is None or move is None:
            return True
        self.tried += 1
        before = parent.notes or Prefix((), np.zeros((0, self._robot.nv)))
        keys = (*before.keys, *self._new_keys(parent.state, move))
        refused = Refused("postures", "no start was made")
        far = np.inf
        for found in self._attempts(before, keys):
            if isinstance(found, Refused):
                refused = found
                continue
            far = min(far, distance := self._palm_distance(branch, keys, found))
            if distance <= self._goal.palm_max_m:
                branch.notes = Prefix(keys, found.q)
                return True
        if far < np.inf:
            self._deaths.add("palm", "too far from the handle")
        else:
            self._deaths.add("postures", f"{refused.kind} at a {move.kind}")
        return False

    def _attempts(self, before: Prefix, keys: tuple[KeyPose, ...]) -> Iterator[Postures | Refused]:
        """Postures for the new key poses and the last one before, then for all from there."""
        known = max(len(before.q) - 1, 0)
        window = keys[known:]
        for found in self._near(before.q[-1:], window):
            if isinstance(found, Refused) or not known:
                yield found
                continue
            chain = self._chain(keys)
            start = np.concatenate((before.q[:known], found.q))
            yield chain.settle(start, self._options.rounds[2])

    def _near(self, last: Array, keys: tuple[KeyPose, ...]) -> Iterator[Postures | Refused]:
        """From where the branch before ended, from the goal's postures, from random starts."""
        options, chain = self._options, self._chain(keys)
        for start in (*last, *self._guidance.q):
            reached = chain.reach(np.repeat(start[None], len(keys), axis=0), options.rounds[1])
            if isinstance(reached, Refused):
                yield reached
            else:
                yield chain.settle(reached, options.rounds[2])
        rng = np.random.default_rng((self._seed, self.tried))
        search = PostureSearch(self._robot, self._world, keys, rng, options)
        yield from search.candidates()
        if search.record.failures:
            kind, _, about = search.record.failures.most_common(1)[0][0].partition(": ")
            yield Refused(kind, about)

    def _chain(self, keys: tuple[KeyPose, ...]) -> PostureChain:
        return PostureChain(self._robot, self._world, keys, self._options.singular_value_min)

    def _new_keys(self, before: GraspState, move: Move) -> Iterator[KeyPose]:
        """Moments that a move adds: those at which a gait's plan asks for postures, too."""
        after = move.after
        if move.kind == "transfer":
            yield self._stood_off(before)
            return
        if move.kind == "addition":
            yield self._key(f"end of {move.name}", after.rotation, after)
            return
        touching = after if move.kind == "lift" else before
        way = Slerp([0.0, 1.0], Rotation.concatenate((before.rotation, after.rotation)))
        for share in (0.0, 0.5, 1.0)[0 if move.kind == "lift" else 1 :]:
            yield self._key(f"{move.name} at {share:g}", way(share), touching)

    def _stood_off(self, state: GraspState) -> KeyPose:
        """Fingers that do not carry the tool are out of its way; then all move as one body."""
        key = self._key("before the transfer", state.rotation, state)
        left = {
            finger: each.contact.standing_off(STAND_OFF_M) for finger, each in state.left.items()
        }
        return KeyPose(key.name, key.rotation, key.position, {**key.contacts, **left})

    def _key(self, name: str, rotation: Rotation, state: GraspState) -> KeyPose:
        contacts = {finger: each.contact for finger, each in state.held.items()}
        position = self._scene.centre_of_mass(rotation)
        return KeyPose(name, rotation.as_matrix(), position, contacts)

    def _palm_distance(
        self, branch: Branch[GraspState, Move], keys: tuple[KeyPose, ...], found: Postures
    ) -> float:
        """Of the goal; 0 before it, where the palm may be anywhere."""
        if not self._goal.reached(branch.state.held) or self._goal.palm_max_m == np.inf:
            return 0.0
        return self._palm(found.q[-1], keys[-1].rotation, keys[-1].position)
