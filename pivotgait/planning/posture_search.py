"""Hand postures for a whole sequence of key poses, by many starts (inverse kinematics).

A start is refined in three rounds, each on what the one before left: the key pose with the most
contacts alone, all key poses together, all of them with collisions. Every constraint is then
checked by itself; what fails is counted by its reason, so that a failed search still tells what
binds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InfeasibleError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import ClosedChain, Hold, TaskJacobian, choose_palm_rows, project
from pivotgait.models import Robot
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose, held_on
from pivotgait.planning.posture_residuals import PostureResiduals
from pivotgait.planning.posture_solver import fit_postures

_NEAR_M = 2e-3  # a tip this far from its contact is pulled in by the next round
_ROLL_RAD = 0.03
_TIGHT_M = 1e-9


@dataclass(frozen=True)
class PostureOptions:
    """How postures are sought.

    Attributes:
        starts: most random starts.
        time_limit_s: no start begins after this time [s].
        singular_value_min: least distance of the scaled task Jacobian H from singularity [m].
        rounds: most iterations of the three rounds.
    """

    starts: int = 400
    time_limit_s: float = 30.0
    singular_value_min: float = 5e-4
    rounds: tuple[int, int, int] = (25, 30, 30)


@dataclass(frozen=True, eq=False)
class Postures(FrozenArrays):
    """Postures that satisfy everything asked for at the key poses.

    Attributes:
        q: (K, nv).
        holds: (finger, contact's name) -> the hold with the direction its tip keeps.
        clearance: smallest distance outside the wanted contacts [m].
        singular_value: smallest distance of H from singularity [m].
        cost: of the fit; lower is more comfortable.
    """

    q: Array
    holds: Mapping[tuple[str, str], Hold]
    clearance: float
    singular_value: float
    cost: float

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "holds", MappingProxyType(dict(self.holds)))


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
        self._hardest = max(range(len(self.keys)), key=lambda k: len(self.keys[k].contacts))
        self._alone = PostureResiduals(robot, [self.keys[self._hardest]])
        self._together = PostureResiduals(robot, self.keys)
        self._clear = PostureResiduals(robot, self.keys, world) if world else self._together
        # Starts spread over one turn only: more turns are the same posture.
        middle = np.clip(robot.home, robot.lower + np.pi, robot.upper - np.pi)
        wide = robot.upper - robot.lower > 2.0 * np.pi
        self._low = np.where(wide, middle - np.pi, robot.lower)
        self._high = np.where(wide, middle + np.pi, robot.upper)

    def candidates(self) -> Iterator[Postures]:
        """Postures that pass every check, in the order they are found."""
        began, record, options = perf_counter(), self.record, self.options
        while record.starts < options.starts and perf_counter() - began < options.time_limit_s:
            record.starts += 1
            result = self._try()
            record.elapsed_s = perf_counter() - began
            if isinstance(result, str):
                record.failures[result] += 1
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

    def _try(self) -> Postures | str:
        alone, together, last = self.options.rounds
        start = self._rng.uniform(self._low, self._high)[None]
        fit = fit_postures(self._alone, start, iterations=alone)
        missed = self._farthest(fit.postures, [self.keys[self._hardest]])
        if missed[0] > _NEAR_M:
            return self._reach(missed)
        fit = fit_postures(
            self._together, np.repeat(fit.postures, len(self.keys), axis=0), iterations=together
        )
        missed = self._farthest(fit.postures, self.keys)
        if missed[0] > _NEAR_M:
            return self._reach(missed)
        fit = fit_postures(self._clear, fit.postures, iterations=last)
        missed = self._farthest(fit.postures, self.keys)
        if missed[0] > _NEAR_M:
            return self._obstructed(fit.postures, missed)
        return self._verify(fit.postures, fit.cost)

    def _farthest(self, postures: Array, keys: Sequence[KeyPose]) -> tuple[float, str]:
        """Largest tip error [m] and the name of its contact."""
        return max(
            (float(np.linalg.norm(error)), key.contacts[finger].name)
            for key, q in zip(keys, postures, strict=True)
            for finger, (error, *_) in self._alone.tips(key, q).items()
        )

    def _reach(self, missed: tuple[float, str]) -> str:
        self.record.missed = min(self.record.missed, missed)
        return f"reach: {missed[1]}"

    def _obstructed(self, postures: Array, missed: tuple[float, str]) -> str:
        """A tip that reached its contact until collisions counted."""
        if self.world is None:
            return self._reach(missed)
        worst = min(self._clearances(self.world, postures))
        return f"collision: {worst[1]}" if worst[0] < self.world.clearance_min else "compromise"

    def _clearances(self, world: CollisionWorld, postures: Array) -> list[tuple[float, str]]:
        found = []
        for key, q in zip(self.keys, postures, strict=True):
            held = world.holding(frozenset(key.contacts))
            distance, pair = held.clearance(q, key.rotation, key.position)
            found.append((distance, " - ".join(pair)))
        return found

    def _verify(self, postures: Array, cost: float) -> Postures | str:
        robot, directions = self.robot, self._directions(postures)
        if isinstance(directions, str):
            return directions
        holds, exact, singular = {}, [], np.inf
        for key, q in zip(self.keys, postures, strict=True):
            mine = {
                (finger, contact.name): Hold.of(
                    robot.fingers[finger],
                    contact.point,
                    contact.normal,
                    directions[finger, contact.name],
                )
                for finger, contact in key.contacts.items()
            }
            holds.update(mine)
            chain = ClosedChain(robot, list(mine.values()))
            end = project(chain, q, key.rotation, key.position, tolerance=_TIGHT_M)
            if not end.converged:
                return "projection"
            if not robot.within_limits(end.q):
                return f"limit: {self._limit(end.q)}"
            task = TaskJacobian(
                robot, list(mine.values()), palm_target=self._palm_axes(end.q, key.rotation)
            )
            choice = choose_palm_rows(task, end.q, key.rotation, key.position)
            singular = min(singular, choice.smallest_singular_value)
            exact.append(end.q)
        if singular < self.options.singular_value_min:
            return "singular: task Jacobian"
        q, clearance = np.array(exact), np.inf
        if self.world is not None:
            clearance, pair = min(self._clearances(self.world, q))
            if clearance < self.world.clearance_min:
                return f"collision: {pair}"
        return Postures(q, holds, clearance, singular, cost)

    def _palm_axes(self, q: Array, oRtool: Array) -> Array:
        """(3, 3) the palm's axes in the tool frame: there its local coordinates are regular."""
        import pinocchio as pin

        data = self.robot.model.createData()
        pin.forwardKinematics(self.robot.model, data, q)
        palm = pin.updateFramePlacement(self.robot.model, data, self.robot.palm_frame_id)
        return np.asarray(oRtool.T @ palm.rotation)

    def _directions(self, postures: Array) -> dict[tuple[str, str], Array] | str:
        """Mean direction in which each tip sees its contact, over the key poses that share it."""
        seen: dict[tuple[str, str], list[Array]] = {}
        at = [self._alone.tips(key, q) for key, q in zip(self.keys, postures, strict=True)]
        for key, tips in zip(self.keys, at, strict=True):
            for finger, (_, _, direction, _) in tips.items():
                seen.setdefault((finger, key.contacts[finger].name), []).append(direction)
        for finger, k, following in held_on(self.keys):
            if np.linalg.norm(at[k][finger][2] - at[following][finger][2]) > _ROLL_RAD:
                return f"rolling: {self.keys[k].contacts[finger].name}"
        mean = {place: np.mean(each, axis=0) for place, each in seen.items()}
        directions = {place: each / np.linalg.norm(each) for place, each in mean.items()}
        for (finger, name), direction in directions.items():
            tip = self.robot.fingers[finger]
            if tip.pad @ direction < np.cos(tip.pad_cone + _ROLL_RAD):
                return f"pad: {name}"
        return directions

    def _limit(self, q: Array) -> str:
        beyond = np.maximum(self.robot.lower - q, q - self.robot.upper)
        worst = int(np.argmax(beyond))
        return self.robot.joint_names[worst] if beyond[worst] > 0.0 else "coupling"
