"""The margins of a gait: how far it is from every edge, and where it comes nearest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from pivotgait.feasibility.carried import CarriedMoments, carried_margins
from pivotgait.feasibility.moments import Moments
from pivotgait.feasibility.robustness import RobustMargins, robust_margins
from pivotgait.feasibility.sensitivity import sensitivity
from pivotgait.feasibility.wrench_ball import WrenchBall, wrench_ball
from pivotgait.feasibility.wrench_volume import WrenchVolume, wrench_volume
from pivotgait.margins import LargestShare, Margin


@dataclass(frozen=True)
class At:
    """A value and the moment it belongs to; ``value`` None where there is none."""

    value: float | None
    phase: str
    time_s: float

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        return {"value": self.value, "phase": self.phase, "time_s": self.time_s}


@dataclass(frozen=True, eq=False)
class GaitMargins:
    """Margins of a gait.

    Attributes:
        friction: smallest friction margin of the forces found, None without phases.
        lift_off: smallest share of the table's range of normal force over its lower bound.
        robust: name of each :class:`RobustMargins` field -> its smallest value over the moments.
        by_phase: phase -> name -> smallest value of its moments; with ``wrench_ball_N``.
        ball: the smallest one at the phases' ends, and its moment.
        volume: of the wrenches at that moment, None if it was not asked for.
        torque: the joint that comes nearest to its torque limit, None without a hand.
        shallowest: the moment whose limits could be tightened least, and how that answers to
            friction and force bounds; None without moments.
    """

    friction: Margin | None
    lift_off: Margin | None
    robust: dict[str, At]
    by_phase: dict[str, dict[str, float | None]]
    ball: tuple[WrenchBall, At] | None
    volume: WrenchVolume | None
    torque: LargestShare | None
    shallowest: Shallowest | None = None

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line; every number finite, None where there is none."""
        ball, volume, torque = None, None, None
        if self.ball is not None:
            found, at = self.ball
            ball = {
                "radius_N": found.radius_N,
                "at_least_N": found.at_least_N,
                "length_m": found.length_m,
                "direction": found.direction.tolist(),
                "phase": at.phase,
                "time_s": at.time_s,
            }
        if self.volume is not None:
            volume = dict(vars(self.volume))
        if self.torque is not None:
            share = self.torque
            torque = {"value": 1.0 - share.value, "joint": share.joint, "phase": share.phase}
            torque["time_s"] = share.time_s
        return {
            "friction": self.friction and self.friction.as_json(),
            "lift_off": self.lift_off and self.lift_off.as_json(),
            "torque": torque,
            "robust": {name: at.as_json() for name, at in self.robust.items()},
            "wrench_ball": ball,
            "wrench_volume": volume,
            "sensitivity": self.shallowest and self.shallowest.as_json(),
            "phases": [{"phase": name, **values} for name, values in self.by_phase.items()],
        }


@dataclass(frozen=True, eq=False)
class Shallowest:
    """The least depth of all moments and its derivatives, see :class:`Sensitivity`.

    Attributes:
        at: the depth [N], phase and time.
        slopes: ``friction`` [N], ``normal_max`` and ``normal_min`` [-] -> contact -> derivative.
    """

    at: At
    slopes: dict[str, dict[str, float]]

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        where = {"phase": self.at.phase, "time_s": self.at.time_s}
        return {"depth_N": self.at.value, **where, **self.slopes}


ROBUST = tuple(each.name for each in fields(RobustMargins))
OF_TABLE = ("table_friction_drop", "lift_off_N", "torque_drop")
"""Margins that a tool off the table has not; of joints' limits only those of the whole plan."""


def gait_margins(
    moments: Sequence[Moments],
    length_m: float,
    *,
    friction: Margin | None = None,
    lift_off: Margin | None = None,
    torque: LargestShare | None = None,
    volume_rng: np.random.Generator | None = None,
    carried: Sequence[CarriedMoments] = (),
) -> GaitMargins:
    """Robust margins of some moments of each phase, and the ball at each phase's end.

    Off the table there is no ball.

    Args:
        moments: of the phases in order.
        length_m: by which moments of force are divided, see :func:`tool_length`.
        friction: smallest margin of the forces found.
        lift_off: the same for the table's normal force.
        torque: the same for the joints.
        volume_rng: of the rays that measure the volume; None leaves it out.
        carried: moments of the transfers, after all others.
    """
    by_phase: dict[str, dict[str, float | None]] = {}
    robust: dict[str, At] = {}
    balls: list[tuple[WrenchBall, Moments]] = []
    for some in moments:
        here = by_phase.setdefault(some.phase, {})
        _keep(robust_margins(some.grasps), some, here, robust, ("torsion_drop",))
        last = some.grasps.take(np.array([some.grasps.count - 1]))
        ball = wrench_ball(last, length_m)
        here["wrench_ball_N"] = ball.radius_N
        balls.append((ball, some))
    for each in carried:
        here = by_phase.setdefault(each.phase, {})
        _keep(carried_margins(each), each, here, robust, OF_TABLE)
        here["wrench_ball_N"] = None
    for name in ROBUST if by_phase else ():
        robust.setdefault(name, At(None, next(iter(by_phase)), 0.0))
    if not balls:
        return GaitMargins(friction, lift_off, {}, {}, None, None, torque)
    ball, some = min(balls, key=lambda each: each[0].radius_N)
    end = some.grasps.take(np.array([some.grasps.count - 1]))
    volume = None if volume_rng is None else wrench_volume(end, length_m, volume_rng)
    at = At(ball.radius_N, some.phase, float(some.time_s[-1]))
    return GaitMargins(
        friction, lift_off, robust, by_phase, (ball, at), volume, torque, _shallowest(moments)
    )


def _keep(
    found: RobustMargins,
    some: Moments | CarriedMoments,
    here: dict[str, float | None],
    robust: dict[str, At],
    absent: Sequence[str],
) -> None:
    """Note the smallest margins of a phase, and those that are the smallest so far.

    Those that are ``absent``, since nothing of the kind is there, are not small.
    """
    for name in ROBUST:
        at = _smallest(getattr(found, name), some)
        here[name] = at.value
        if name in absent:
            continue
        known = robust.get(name)
        if known is None or _order(at) < _order(known):
            robust[name] = at


def _shallowest(moments: Sequence[Moments]) -> Shallowest | None:
    """None where the wrench of some moment is out of reach of any forces."""
    found = [(sensitivity(some.grasps), some) for some in moments]
    least, some = min(found, key=lambda each: float(each[0].depth.min()))
    k = int(np.argmin(least.depth))
    depth = float(least.depth[k])
    if not np.isfinite(depth):
        return None
    slopes = {
        name: dict(zip(some.grasps.names, getattr(least, name)[k].tolist(), strict=True))
        for name in ("friction", "normal_max", "normal_min")
    }
    return Shallowest(At(depth, some.phase, float(some.time_s[k])), slopes)


def _smallest(values: Any, some: Moments | CarriedMoments) -> At:
    """The least value, None where it is missing or without bound."""
    known = np.where(np.isnan(values), -np.inf, values)
    k = int(np.argmin(known))
    value = float(known[k])
    return At(value if np.isfinite(value) else None, some.phase, float(some.time_s[k]))


def _order(at: At) -> float:
    return -np.inf if at.value is None else at.value
