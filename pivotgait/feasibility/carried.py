"""Robust margins of a tool off the table, carried by soft fingertips alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts.cone import split_force
from pivotgait.dynamics import PivotingTool, required_wrench
from pivotgait.feasibility.edges import Index, last_feasible
from pivotgait.feasibility.moments import taken, telling_samples
from pivotgait.feasibility.robustness import (
    HEAVIER,
    LARGEST_FACTOR,
    LEAST_FACTOR,
    LEAST_FORCE_N,
    SHARE_MAX,
    RobustMargins,
    drop_of,
    sensing_share,
)
from pivotgait.forces.soft_finger import SoftFingerProblem
from pivotgait.forces.soft_range import SoftFingerRange
from pivotgait.frozen import Array
from pivotgait.plans import PIVOT, Phase


@dataclass(frozen=True, eq=False)
class CarriedMoments:
    """Some moments of a transfer.

    Attributes:
        phase: its name.
        time_s: (B,) from the phase's start [s].
        problem: what the fingers apply then, with the whole friction; what the table still
            applies is taken as planned.
        force: (B, m, 3) of the plan [N].
    """

    phase: str
    time_s: Array
    problem: SoftFingerProblem
    force: Array


def carried_moments(phase: Phase, body: PivotingTool) -> CarriedMoments:
    """The middle of a transfer, its weakest moment by friction, and its end."""
    at = telling_samples(phase)
    motion = taken(phase.tool, at)
    tracks = [track for name, track in phase.contacts.items() if name != PIVOT]
    pivot = phase.contacts[PIVOT]
    arm = motion.rotation.as_matrix() @ body.pivot_in_tool
    by_pivot = np.concatenate((pivot.force[at], np.cross(arm, pivot.force[at])), axis=1)
    points = np.stack([track.world_point(phase.tool)[at] for track in tracks], axis=1)
    force = np.stack([track.force[at] for track in tracks], axis=1)
    problem = SoftFingerProblem(
        names=tuple(track.name for track in tracks),
        lever=points - motion.position[:, None],
        normals=np.stack([track.world_normal(phase.tool)[at] for track in tracks], axis=1),
        friction=np.array([track.friction for track in tracks]),
        torsion=np.array([track.torsion for track in tracks]),
        normal_min=np.array([track.normal_min for track in tracks]),
        normal_max=np.array([track.normal_max for track in tracks]),
        wrench=required_wrench(body, motion) - by_pivot,
        start=force[0],
        # moments are judged one by one
        force_rate_max=np.inf,
        step_s=1.0,
    )
    return CarriedMoments(phase.name, phase.time[at] - phase.time[0], problem, force)


def carried_margins(moments: CarriedMoments) -> RobustMargins:
    """Robust margins of soft fingers, as :func:`robust_margins` of point contacts.

    The friction that drops is all of the fingers': Coulomb's and torsional; ``torsion_drop`` is
    of the latter alone. There is no table, and the joints' limits are left out.
    """
    ranges = [SoftFingerRange(moments.problem, k) for k in range(len(moments.time_s))]
    count = len(ranges)
    held = np.array([each.holds() for each in ranges])
    nothing = np.full(count, np.nan)
    both = _drop(ranges, torsion_alone=False)
    lighter, heavier = np.array([each.load() or (np.nan, np.nan) for each in ranges]).T
    return RobustMargins(
        friction_drop=both,
        finger_friction_drop=both,
        table_friction_drop=nothing,
        torsion_drop=_drop(ranges, torsion_alone=True),
        mass_increase=np.where(held, np.minimum(heavier, HEAVIER) - 1.0, np.nan),
        mass_decrease=np.where(held, 1.0 - np.maximum(lighter, 0.0), np.nan),
        lift_off_N=nothing,
        sensing_share=np.where(held, _sensing_share(moments, ranges), np.nan),
        torque_drop=nothing,
    )


def _drop(ranges: list[SoftFingerRange], *, torsion_alone: bool) -> Array:
    def holds(line: Index, value: Array) -> NDArray[np.bool_]:
        good = []
        for place, factor in zip(line.tolist(), np.exp(value).tolist(), strict=True):
            friction = 1.0 if torsion_alone else factor
            good.append(ranges[place].holds(friction=friction, torsion=factor))
        return np.array(good)

    strong, weak = np.log(LARGEST_FACTOR), np.log(LEAST_FACTOR)
    edges = last_feasible(np.full(len(ranges), strong), np.full(len(ranges), weak), holds)
    return drop_of(edges)


def _sensing_share(moments: CarriedMoments, ranges: list[SoftFingerRange]) -> Array:
    """(B,) least share of all fingers that press."""
    normal, tangent = split_force(moments.force, moments.problem.normals)
    least = np.full(len(ranges), SHARE_MAX)
    for finger in range(len(moments.problem.names)):
        ends = np.array([each.normal(finger) or (np.nan, np.nan) for each in ranges])
        at = np.nonzero(np.isfinite(ends[:, 0]) & (normal[:, finger] > LEAST_FORCE_N))[0]
        wanted = normal[at, finger]
        found = sensing_share(tangent[at, finger] / wanted, wanted, *ends[at].T)
        least[at] = np.minimum(least[at], found)
    return least
