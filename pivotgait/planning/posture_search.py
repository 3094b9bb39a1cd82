"""Hand postures for a whole sequence of key poses, by many starts (inverse kinematics).

A start is refined in three rounds, each on what the one before left: the key pose with the most
contacts alone, all key poses together, all of them with collisions. Every constraint is then
checked by itself; what fails is counted by its reason, so that a failed search still tells what
binds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from pivotgait.exceptions import InfeasibleError
from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused


@dataclass(frozen=True)
class PostureOptions:
    """How postures are sought.

    Attributes:
        starts: most random starts.
        time_limit_s: no start begins after this time [s].
        singular_value_min: least distance of the scaled task Jacobian H from singularity [m].
        rounds: most iterations of the three rounds.
        near_home: share of the joints' ranges that every second start spreads over, about home.
    """

    starts: int = 400
    time_limit_s: float = 30.0
    singular_value_min: float = 5e-4
    rounds: tuple[int, int, int] = (25, 30, 30)
    near_home: float = 0.25


@dataclass
class SearchRecord:
    """What a search has tried so far.

    Attributes:
        starts: begun.
        found: postures that passed.
        failures: reason -> number of starts.
        missed: largest tip error of the best start that missed a contact [m], and its contact.
        elapsed_s: time spent [s].
    """

    starts: int = 0
    found: int = 0
    failures: Counter[str] = field(default_factory=Counter)
    missed: tuple[float, str] = (np.inf, "")
    elapsed_s: float = 0.0

    def infeasible(self, where: str) -> InfeasibleError:
        """The error that tells what bound most often."""
        reason = self.failures.most_common(1)[0][0] if self.failures else "no start was made"
        out_of_reach = sum(n for name, n in self.failures.items() if name.startswith("reach"))
        what = f"no posture in {self.starts} starts; most often: {reason}"
        if out_of_reach == self.starts > 0:
            distance, contact = self.missed
            what = (
                f"no posture in {self.starts} starts: {contact} stays {1e3 * distance:.1f} mm off"
            )
        mend = "move the contact, the tool's place or the robot's base"
        return InfeasibleError(what, where=where, mend=mend)


class PostureSearch:
    """Postures for key poses, one after the other as they are found.

    Args:
        robot: the arm-hand.
        world: what must not be touched; None leaves collisions out.
        keys: in the order of time.
        rng: source of starts.
        options: how to search.

    Attributes:
        record: of the search so far.
    """

    def __init__(
        self,
        robot: Robot,
        world: CollisionWorld | None,
        keys: Sequence[KeyPose],
        rng: np.random.Generator,
        options: PostureOptions | None = None,
    ) -> None:
        self.robot, self.world, self.keys = robot, world, tuple(keys)
        self.options, self.record = options or PostureOptions(), SearchRecord()
        self._rng = rng
        least = self.options.singular_value_min
        hardest = max(self.keys, key=lambda key: len(key.contacts))
        self._alone = PostureChain(robot, None, [hardest], least)
        self._chain = PostureChain(robot, world, self.keys, least)
        # Starts spread over one turn only: more turns are the same posture.
        self._reach = np.minimum(robot.upper - robot.lower, 2.0 * np.pi)
        middle = 0.5 * (robot.upper + robot.lower)
        self._middle = np.where(self._reach < 2.0 * np.pi, middle, robot.home)

    def candidates(self) -> Iterator[Postures]:
        """Postures that pass every check, in the order they are found."""
        began, record, options = perf_counter(), self.record, self.options
        while record.starts < options.starts and perf_counter() - began < options.time_limit_s:
            record.starts += 1
            result = self._try()
            record.elapsed_s = perf_counter() - began
            if isinstance(result, Refused):
                record.failures[result.reason] += 1
                if result.kind == "reach":
                    record.missed = min(record.missed, (result.distance, result.about))
                continue
            record.found += 1
            yield result

    def first(self, where: str = "inverse kinematics") -> Postures:
        """The first postures found.

        Raises:
            InfeasibleError: naming what bound most often.
        """
        for postures in self.candidates():
            return postures
        raise self.record.infeasible(where)

    def _try(self) -> Postures | Refused:
        alone, together, last = self.options.rounds
        posture = self._alone.reach(self._start()[None], alone)
        if isinstance(posture, Refused):
            return posture
        postures = self._chain.reach(np.repeat(posture, len(self.keys), axis=0), together)
        if isinstance(postures, Refused):
            return postures
        return self._chain.settle(postures, last)

    def _start(self) -> Array:
        """A random configuration: in turns anywhere, and near home."""
        robot, spread = self.robot, self._reach * self._rng.uniform(-0.5, 0.5, self.robot.nv)
        if self.record.starts % 2:
            return np.clip(self._middle + spread, robot.lower, robot.upper)
        return np.clip(robot.home + self.options.near_home * spread, robot.lower, robot.upper)
