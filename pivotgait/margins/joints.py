"""How much of their limits the joints use: shares of range, speed and torque."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.urdf import check_urdf
from pivotgait.plans.plan import GaitPlan

ShareKind = Literal["range", "speed", "torque"]
SHARE_KINDS: tuple[ShareKind, ...] = ("range", "speed", "torque")


@dataclass(frozen=True, eq=False)
class JointShares(FrozenArrays):
    """The joints at the N samples of a phase, in the order of the planned robot.

    Attributes:
        phase: its name.
        time: (N,) from the phase's start [s].
        range: (N, n) place between the lower limit (-1) and the upper one (1).
        speed: (N, n) velocity over its limit.
        torque: (N, n) torque or force over its limit (Xue et al., eq. 17).
    """

    phase: str
    time: Array
    range: Array
    speed: Array
    torque: Array

    def of(self, kind: ShareKind) -> Array:
        """(N, n) shares of one kind; a limit is kept up to 1 in magnitude."""
        found: Array = getattr(self, kind)
        return found


@dataclass(frozen=True)
class LargestShare:
    """The joint that uses most of a limit.

    Attributes:
        kind: range, speed or torque.
        joint: its name.
        phase: name of the phase.
        time_s: from the phase's start [s].
        value: magnitude of the share; above 1 if the limit is broken.
    """

    kind: ShareKind
    joint: str
    phase: str
    time_s: float
    value: float

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        return asdict(self)


def joint_shares(plan: GaitPlan) -> tuple[JointShares, ...]:
    """Shares of every phase in order; none for a plan without a robot.

    Raises:
        UrdfError: if the robot's URDF is broken.
    """
    if plan.robot is None:
        return ()
    joints = check_urdf(plan.robot.urdf, where="the plan's robot").joints
    chosen = [joints[name] for name in plan.robot.joint_names]
    lower, upper = (np.array([getattr(j, end) for j in chosen]) for end in ("lower", "upper"))
    speed, effort = (np.array([getattr(j, end) for j in chosen]) for end in ("velocity", "effort"))
    return tuple(
        JointShares(
            phase.name,
            phase.time - phase.time[0],
            (2.0 * phase.robot.q - lower - upper) / (upper - lower),
            phase.robot.v / speed,
            phase.robot.tau / effort,
        )
        for phase in plan.phases
        if phase.robot is not None
    )


def largest_share(
    plan: GaitPlan, kind: ShareKind, *, phase: str | None = None
) -> LargestShare | None:
    """The joint that comes nearest to a limit of one kind, the earliest of equals.

    Args:
        plan: a gait.
        kind: which limit.
        phase: name of the only phase to look at, None for all.

    Returns:
        None for a plan without a robot.
    """
    names = plan.robot.joint_names if plan.robot else ()
    found = _largest_of_phases(joint_shares(plan), names, kind)
    return max(
        (each for each in found if phase in (None, each.phase)),
        key=lambda each: each.value,
        default=None,
    )


def _largest_of_phases(
    phases: tuple[JointShares, ...], names: tuple[str, ...], kind: ShareKind
) -> Iterator[LargestShare]:
    for shares in phases:
        size = np.abs(shares.of(kind))
        sample, joint = np.unravel_index(int(np.argmax(size)), size.shape)
        yield LargestShare(
            kind,
            names[joint],
            shares.phase,
            float(shares.time[sample]),
            float(size[sample, joint]),
        )
