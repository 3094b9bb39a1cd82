"""Postures of the hand for all of a branch so far: dearer than forces, cheaper than a plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from pivotgait.frozen import Array
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.guidance import Guidance
from pivotgait.gait_search.hand_fit import HandFit
from pivotgait.gait_search.move_keys import keys_of_move, keys_to_come
from pivotgait.gait_search.notes import PATIENCE, Branches, Prefix, notes_of
from pivotgait.gait_search.palm import PalmDistance
from pivotgait.gait_search.room import with_room
from pivotgait.models import Scene
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import Postures, Refused

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
        fit: of the hand.
        goal: of the search; says how near the palm must be in the end.
        deaths: counts branches without postures.
        guidance: postures at the goal, from which each branch is tried, too.

    Attributes:
        tried: number of branches tested.
    """

    def __init__(
        self,
        scene: Scene,
        fit: HandFit,
        goal: Goal,
        deaths: Deaths,
        guidance: Guidance,
    ) -> None:
        self._scene, self._fit, self._goal = scene, fit, goal
        self._deaths, self._guidance = deaths, guidance
        self._palm = PalmDistance(fit.robot, scene.tool)
        self.tried = 0

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
        chain = self._fit.chain(tuple(each.key for each in moments))
        start = prefix.q[[each.like for each in moments]]
        found = chain.settle(start, 2 * self._fit.rounds[2])
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
        before = notes_of(parent).prefix or Prefix((), np.zeros((0, self._fit.robot.nv)), 0)
        new = tuple(keys_of_move(self._scene, parent.state, move))
        come = tuple(keys_to_come(self._scene, notes_of(branch).rest))
        keys = (*before.keys[: before.done], *new, *come)
        return Task(keys, before, before.done + len(new), notes_of(branch).alone)

    def _near(self, task: Task) -> Iterator[Postures | Refused]:
        """From where the branch before was and was to go, then from the goal's postures."""
        if task.before.done:
            yield self._fit.chain(task.keys).settle(task.start(), self._fit.rounds[2])
        if task.alone is not None:
            come = len(task.keys) - task.done
            for later in (task.alone[-1], *self._guidance.q):
                start = np.concatenate((task.alone, np.repeat(later[None], come, axis=0)))
                yield self._fit.chain(task.keys).settle(start, self._fit.rounds[2])
            return
        for start in (*self._guidance.q, self._fit.robot.home):
            yield from self._window(task, self._reached(task, start))

    def _reached(self, task: Task, start: Array) -> Postures | Refused:
        window = task.keys[task.known :]
        chain, rounds = self._fit.chain(window), self._fit.rounds
        reached = chain.reach(np.repeat(start[None], len(window), axis=0), rounds[1])
        return reached if isinstance(reached, Refused) else chain.settle(reached, rounds[2])

    def _anywhere(self, task: Task) -> Iterator[Postures | Refused]:
        """From random starts."""
        for found in self._fit.anywhere(task.keys[task.known :], self.tried):
            yield from self._window(task, found)

    def _window(self, task: Task, found: Postures | Refused) -> Iterator[Postures | Refused]:
        """Postures for the last key poses taken on to all of them."""
        if isinstance(found, Refused) or not task.known:
            yield found
            return
        start = np.concatenate((task.before.q[: task.known], found.q))
        yield self._fit.chain(task.keys).settle(start, self._fit.rounds[2])

    def _palm_distance(self, branch: Branches, keys: tuple[KeyPose, ...], found: Postures) -> float:
        """Of the goal; 0 before it, where the palm may be anywhere."""
        if not self._goal.reached(branch.state.held) or self._goal.palm_max_m == np.inf:
            return 0.0
        return self._palm(found.q[-1], keys[-1].rotation, keys[-1].position)


def _names(key: KeyPose) -> frozenset[str]:
    return frozenset(each.name for each in key.contacts.values())
