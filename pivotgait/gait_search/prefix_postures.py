"""Postures of the hand for all of a branch so far: dearer than forces, cheaper than a plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.notes import Branches, Prefix, notes_of
from pivotgait.gait_search.palm import PalmDistance
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.timing import STAND_OFF_M
from pivotgait.models import Robot, Scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_search import PostureOptions, PostureSearch

PATIENCE = 5.0
"""Branches that costs say are so much worse are looked at before random starts are made."""
_PALM = "palm"


@dataclass(frozen=True, eq=False)
class Task:
    """What postures are sought for.

    Attributes:
        keys: of the branch before, of its own move, and to come.
        before: of the branch before.
        done: number of key poses without those to come.
    """

    keys: tuple[KeyPose, ...]
    before: Prefix
    done: int

    @property
    def known(self) -> int:
        """Key poses whose postures may stay as they are: all of the branch before but its last."""
        return max(self.before.done - 1, 0)

    def start(self) -> Array:
        """(K, nv) postures of the branch before: its own, and those it had in view, by contacts."""
        before = self.before
        seen = {_names(key): q for key, q in zip(before.keys, before.q, strict=True)}
        last = before.q[before.done - 1]
        later = [seen.get(_names(key), last) for key in self.keys[before.done :]]
        return np.concatenate((before.q[: before.done], np.array(later)))


class PrefixPostures:
    """Tests whether the hand has postures for a branch and for what is to come after it.

    Args:
        scene: with a robot.
        robot: of the scene.
        goal: of the search; says how near the palm must be in the end.
        deaths: counts branches without postures.
        guidance: postures at the goal, from which each branch is tried, too.
        options: of the random starts for a branch.
        seed: of the starts; the same seed gives the same postures.

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
        options: PostureOptions,
        seed: int,
    ) -> None:
        self._scene, self._robot, self._goal, self._deaths = scene, robot, goal, deaths
        self._guidance, self._options, self._seed = guidance, options, seed
        self._world = CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)
        self._palm = PalmDistance(robot, scene.tool)
        self.tried = 0

    def quick(self, branch: Branches) -> bool:
        """Look for postures near known ones; without them the branch waits, but lives on."""
        if branch.parent is None or branch.move is None:
            return True
        self.tried += 1
        if isinstance(self._fitted(branch, self._near), Refused):
            branch.delay += PATIENCE
        return True

    def thorough(self, branch: Branches) -> bool:
        """Look for postures from random starts unless some are known; they are the last hope."""
        if branch.parent is None or branch.move is None or notes_of(branch).prefix is not None:
            return True
        refused = self._fitted(branch, self._anywhere)
        if refused is None:
            return True
        if refused.kind == _PALM:
            self._deaths.add("palm", "too far from the handle")
        else:
            self._deaths.add("postures", f"{refused.kind} at a {branch.move.kind}")
        return False

    def _fitted(
        self, branch: Branches, attempts: Callable[[Task], Iterator[Postures | Refused]]
    ) -> Refused | None:
        """Postures from the first attempt that gives some, as the branch's notes; or why not."""
        task = self._task(branch)
        refused = Refused("reach", "no start")
        for found in attempts(task):
            if isinstance(found, Refused):
                refused = found
            elif self._palm_distance(branch, task.keys, found) > self._goal.palm_max_m:
                refused = Refused(_PALM, "handle")
            else:
                branch.notes = replace(
                    notes_of(branch), prefix=Prefix(task.keys, found.q, task.done)
                )
                return None
        return refused

    def _task(self, branch: Branches) -> Task:
        """Key poses so far, those of the branch's own move, and those to come."""
        parent, move = branch.parent, branch.move
        assert parent is not None
        assert move is not None
        before = notes_of(parent).prefix or Prefix((), np.zeros((0, self._robot.nv)), 0)
        new = tuple(self._new_keys(parent.state, move))
        come = tuple(self._keys_to_come(notes_of(branch).rest))
        return Task((*before.keys[: before.done], *new, *come), before, before.done + len(new))

    def _near(self, task: Task) -> Iterator[Postures | Refused]:
        """From where the branch before was and was to go, then from the goal's postures."""
        if task.before.done:
            yield self._chain(task.keys).settle(task.start(), self._options.rounds[2])
        for start in (*self._guidance.q, self._robot.home):
            yield from self._window(task, self._reached(task, start))

    def _reached(self, task: Task, start: Array) -> Postures | Refused:
        window = task.keys[task.known :]
        chain, rounds = self._chain(window), self._options.rounds
        reached = chain.reach(np.repeat(start[None], len(window), axis=0), rounds[1])
        return reached if isinstance(reached, Refused) else chain.settle(reached, rounds[2])

    def _anywhere(self, task: Task) -> Iterator[Postures | Refused]:
        """From random starts."""
        rng = np.random.default_rng((self._seed, self.tried))
        keys = task.keys[task.known :]
        search = PostureSearch(self._robot, self._world, keys, rng, self._options)
        for found in search.candidates():
            yield from self._window(task, found)
        if search.record.failures:
            kind, _, about = search.record.failures.most_common(1)[0][0].partition(": ")
            yield Refused(kind, about)

    def _window(self, task: Task, found: Postures | Refused) -> Iterator[Postures | Refused]:
        """Postures for the last key poses taken on to all of them."""
        if isinstance(found, Refused) or not task.known:
            yield found
            return
        start = np.concatenate((task.before.q[: task.known], found.q))
        yield self._chain(task.keys).settle(start, self._options.rounds[2])

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

    def _keys_to_come(self, rest: Sequence[Move]) -> Iterator[KeyPose]:
        """The grasps that fingers are added to, up to the goal."""
        for move in rest:
            if move.kind == "addition":
                yield self._key(f"end of {move.name}", move.after.rotation, move.after)

    def _key(self, name: str, rotation: Rotation, state: GraspState) -> KeyPose:
        contacts = {finger: each.contact for finger, each in state.held.items()}
        position = self._scene.centre_of_mass(rotation)
        return KeyPose(name, rotation.as_matrix(), position, contacts)

    def _palm_distance(self, branch: Branches, keys: tuple[KeyPose, ...], found: Postures) -> float:
        """Of the goal; 0 before it, where the palm may be anywhere."""
        if not self._goal.reached(branch.state.held) or self._goal.palm_max_m == np.inf:
            return 0.0
        return self._palm(found.q[-1], keys[-1].rotation, keys[-1].position)


def _names(key: KeyPose) -> frozenset[str]:
    return frozenset(each.name for each in key.contacts.values())
