"""Postures of the hand for all of a branch so far: dearer than forces, cheaper than a plan."""

from __future__ import annotations

from collections import defaultdict
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
from pivotgait.gait_search.room import with_room
from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.timing import STAND_OFF_M
from pivotgait.models import Robot, Scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_search import PostureOptions, PostureSearch

PATIENCE = 5.0
"""Branches that costs say are so much worse are looked at before random starts are made."""
EAGERNESS = 4.0
"""A lift that the hand can do is followed up before others that cost so much less are tried."""
_PALM = "palm"


@dataclass(frozen=True, eq=False)
class Task:
    """What postures are sought for.

    Attributes:
        keys: of the branch before, of its own move, and to come.
        before: of the branch before.
        done: number of key poses without those to come.
        alone: (done, nv) postures of a lift by itself, if that is what it is for.
    """

    keys: tuple[KeyPose, ...]
    before: Prefix
    done: int
    alone: Array | None = None

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
        self._experience: dict[frozenset[str], _Experience] = defaultdict(_Experience)
        self.tried = 0

    def expect(self, branch: Branches) -> bool:
        """A lift by fingers whose lifts have failed so far waits longer than others."""
        if (move := branch.move) is not None and move.kind == "lift":
            branch.delay += PATIENCE * self._experience[_fingers(move)].failing
        return True

    def alone(self, branch: Branches) -> bool:
        """Look for postures of a lift by itself: most that have none fail on the table already."""
        if branch.parent is None or (move := branch.move) is None or move.kind != "lift":
            return True
        keys = tuple(self._new_keys(branch.parent.state, move))
        found = self._lifting(keys)
        self._experience[_fingers(move)].add(found is not None)
        if found is None:
            branch.delay += PATIENCE
        else:
            branch.delay -= EAGERNESS
            branch.notes = replace(notes_of(branch), alone=found)
        return True

    def _lifting(self, keys: tuple[KeyPose, ...]) -> Array | None:
        if not len(self._guidance.q):
            found = next((each for each in self._random(keys) if isinstance(each, Postures)), None)
            return None if found is None else found.q
        rounds = self._options.rounds[2]
        for start in (*self._guidance.q, self._robot.home):
            lying = self._chain(keys[:1]).settle(start[None], rounds)
            if isinstance(lying, Refused):
                continue
            lifted = self._chain(keys).settle(np.repeat(lying.q, len(keys), axis=0), rounds)
            if not isinstance(lifted, Refused):
                return lifted.q
        return None

    def quick(self, branch: Branches) -> bool:
        """Look for postures near known ones; without them the branch waits, but lives on."""
        if branch.parent is None or branch.move is None:
            return True
        if branch.move.kind == "lift" and notes_of(branch).alone is None:
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

    def roomy(self, branch: Branches) -> bool:
        """Fit a whole sequence once more, with room for fingers beside the contacts they change."""
        prefix = notes_of(branch).prefix
        if prefix is None or not self._goal.reached(branch.state.held):
            return True
        moments = list(with_room(branch.path()))
        chain = self._chain(tuple(each.key for each in moments))
        start = prefix.q[[each.like for each in moments]]
        found = chain.settle(start, 2 * self._options.rounds[2])
        if isinstance(found, Refused):
            self._deaths.add("postures", f"{found.kind} beside a contact")
            return False
        q = found.q[[each.own for each in moments]]
        branch.notes = replace(notes_of(branch), prefix=Prefix(prefix.keys[: len(q)], q, len(q)))
        return True

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
        keys = (*before.keys[: before.done], *new, *come)
        return Task(keys, before, before.done + len(new), notes_of(branch).alone)

    def _near(self, task: Task) -> Iterator[Postures | Refused]:
        """From where the branch before was and was to go, then from the goal's postures."""
        if task.before.done:
            yield self._chain(task.keys).settle(task.start(), self._options.rounds[2])
        if task.alone is not None:
            come = len(task.keys) - task.done
            for later in (task.alone[-1], *self._guidance.q):
                start = np.concatenate((task.alone, np.repeat(later[None], come, axis=0)))
                yield self._chain(task.keys).settle(start, self._options.rounds[2])
            return
        for start in (*self._guidance.q, self._robot.home):
            yield from self._window(task, self._reached(task, start))

    def _reached(self, task: Task, start: Array) -> Postures | Refused:
        window = task.keys[task.known :]
        chain, rounds = self._chain(window), self._options.rounds
        reached = chain.reach(np.repeat(start[None], len(window), axis=0), rounds[1])
        return reached if isinstance(reached, Refused) else chain.settle(reached, rounds[2])

    def _anywhere(self, task: Task) -> Iterator[Postures | Refused]:
        """From random starts."""
        for found in self._random(task.keys[task.known :]):
            yield from self._window(task, found)

    def _random(self, keys: tuple[KeyPose, ...]) -> Iterator[Postures | Refused]:
        """Postures from random starts, then why the others failed most often."""
        rng = np.random.default_rng((self._seed, self.tried))
        search = PostureSearch(self._robot, self._world, keys, rng, self._options)
        yield from search.candidates()
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
        """Moments that a move adds."""
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
        return replace(key, contacts={**key.contacts, **left})

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


@dataclass
class _Experience:
    """With lifts by the same fingers."""

    tried: int = 0
    passed: int = 0

    @property
    def failing(self) -> float:
        """Share of failures to expect of the next one; 0 before the first."""
        return (self.tried - self.passed) / (self.tried + 1)

    def add(self, passed: bool) -> None:
        """Count one more."""
        self.tried, self.passed = self.tried + 1, self.passed + passed


def _fingers(move: Move) -> frozenset[str]:
    return frozenset(each.finger for each in move.contacts)


def _names(key: KeyPose) -> frozenset[str]:
    return frozenset(each.name for each in key.contacts.values())
