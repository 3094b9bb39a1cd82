"""Postures for a chain of key poses: fitted together from a start, then checked one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.kinematics import (
    ClosedChain,
    Hold,
    TaskJacobian,
    choose_palm_rows,
    palm_axes,
    project,
)
from pivotgait.models import Robot
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose, held_on
from pivotgait.planning.posture_residuals import PostureResiduals
from pivotgait.planning.posture_solver import fit_postures

NEAR_M = 2e-3
"""A tip this far from its contact is pulled in by the next round."""
_FAR_M = 2e-2
"""Farther from a contact than this a posture belongs to another grasp."""
_ROLL_RAD = 0.03
_MEASURED_ROLL_RAD = 0.1
"""Of fingertips that have held for a while, against where the plan wants them later."""
_TIGHT_M = 1e-11


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


@dataclass(frozen=True)
class Refused:
    """Why postures do not do.

    Attributes:
        kind: of the fault.
        about: contact, joint, pair or method that it is about.
        distance: by which a contact is missed [m], 0 for other faults.
    """

    kind: str
    about: str
    distance: float = 0.0

    @property
    def reason(self) -> str:
        """Kind and what it is about, for messages."""
        return f"{self.kind}: {self.about}"


class PostureChain:
    """Key poses in the order of time, and what their postures must satisfy.

    Args:
        robot: the arm-hand.
        world: what must not be touched; None leaves collisions out.
        keys: in the order of time.
        singular_value_min: least distance of the scaled task Jacobian H from singularity [m].
    """

    def __init__(
        self,
        robot: Robot,
        world: CollisionWorld | None,
        keys: Sequence[KeyPose],
        singular_value_min: float,
    ) -> None:
        self.robot, self.world, self.keys = robot, world, tuple(keys)
        self.singular_value_min = singular_value_min
        self._reaching = PostureResiduals(robot, self.keys)
        self._clear = PostureResiduals(robot, self.keys, world) if world else self._reaching

    def reach(self, start: Array, iterations: int) -> Array | Refused:
        """Postures (K, nv) fitted to the contacts from ``start``, collisions left out."""
        fit = fit_postures(self._reaching, start, iterations=iterations)
        missed = self.farthest(fit.postures)
        return Refused("reach", missed[1], missed[0]) if missed[0] > NEAR_M else fit.postures

    def settle(self, start: Array, iterations: int) -> Postures | Refused:
        """Postures fitted to everything from ``start`` (K, nv), closed exactly and checked."""
        fit = fit_postures(self._clear, start, iterations=iterations)
        missed = self.farthest(fit.postures)
        if missed[0] > NEAR_M:
            return self._obstructed(fit.postures, missed)
        return self._verify(fit.postures, fit.cost)

    def closed(self, start: Array) -> Postures | Refused:
        """Postures next to ``start`` (K, nv), closed exactly and checked without any fit.

        Each is the one on its contacts that steps of least norm find, so postures that satisfy
        everything already stay as they are.
        """
        missed = self.farthest(start)
        if missed[0] > _FAR_M:
            return Refused("reach", missed[1], missed[0])
        return self._verify(start, 0.0, roll=_MEASURED_ROLL_RAD)

    def farthest(self, postures: Array) -> tuple[float, str]:
        """Largest tip error [m] and the name of its contact."""
        return max(
            (float(np.linalg.norm(error)), key.contacts[finger].name)
            for key, q in zip(self.keys, postures, strict=True)
            for finger, (error, *_) in self._reaching.tips(key, q).items()
        )

    def _obstructed(self, postures: Array, missed: tuple[float, str]) -> Refused:
        """A tip that reached its contact until collisions counted."""
        if self.world is None:
            return Refused("reach", missed[1], missed[0])
        worst = min(self._clearances(self.world, postures))
        if worst[0] < self.world.clearance_min:
            return Refused("collision", worst[1])
        return Refused("compromise", missed[1])

    def _clearances(self, world: CollisionWorld, postures: Array) -> list[tuple[float, str]]:
        found = []
        for key, q in zip(self.keys, postures, strict=True):
            held = world.holding(frozenset(key.contacts))
            distance, pair = held.clearance(q, key.rotation, key.position)
            found.append((distance, " - ".join(pair)))
        return found

    def _verify(
        self, postures: Array, cost: float, *, roll: float = _ROLL_RAD
    ) -> Postures | Refused:
        robot, directions = self.robot, self._directions(postures, roll)
        if isinstance(directions, Refused):
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
                return Refused("projection", "Newton's method")
            if not robot.within_limits(end.q):
                return Refused("limit", self._limit(end.q))
            task = TaskJacobian(
                robot, list(mine.values()), palm_target=palm_axes(robot, end.q, key.rotation)
            )
            choice = choose_palm_rows(task, end.q, key.rotation, key.position)
            singular = min(singular, choice.smallest_singular_value)
            exact.append(end.q)
        if singular < self.singular_value_min:
            return Refused("singular", "task Jacobian")
        q, clearance = np.array(exact), np.inf
        if self.world is not None:
            clearance, pair = min(self._clearances(self.world, q))
            if clearance < self.world.clearance_min:
                return Refused("collision", pair)
        return Postures(q, holds, clearance, singular, cost)

    def _directions(self, postures: Array, roll: float) -> dict[tuple[str, str], Array] | Refused:
        """Mean direction in which each tip sees its contact, over the key poses that share it."""
        seen: dict[tuple[str, str], list[Array]] = {}
        at = [self._reaching.tips(key, q) for key, q in zip(self.keys, postures, strict=True)]
        for key, tips in zip(self.keys, at, strict=True):
            for finger, (_, _, direction, _) in tips.items():
                seen.setdefault((finger, key.contacts[finger].name), []).append(direction)
        for finger, k, following in held_on(self.keys):
            if np.linalg.norm(at[k][finger][2] - at[following][finger][2]) > roll:
                return Refused("rolling", self.keys[k].contacts[finger].name)
        mean = {place: np.mean(each, axis=0) for place, each in seen.items()}
        directions = {place: each / np.linalg.norm(each) for place, each in mean.items()}
        for (finger, name), direction in directions.items():
            tip = self.robot.fingers[finger]
            if tip.pad @ direction < np.cos(tip.pad_cone + roll):
                return Refused("pad", name)
        return directions

    def _limit(self, q: Array) -> str:
        beyond = self.robot.beyond_range(q)
        worst = int(np.argmax(beyond))
        return self.robot.joint_names[worst] if beyond[worst] > 0.0 else "coupling"
