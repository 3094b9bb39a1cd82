"""Robust margins: how large an error in the data the remaining allocation still absorbs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.contacts.cone import split_force
from pivotgait.feasibility.edges import Index, last_feasible
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.forces import LinearRows
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plans import PIVOT

LEAST_FACTOR, LARGEST_FACTOR = 1e-3, 32.0
"""Friction is varied between these factors."""
HEAVIER = 10.0
"""Largest mass tried, over the assumed one."""
SIZE_ERROR, ANGLE_ERROR_RAD = 0.25, np.radians(30.0)
"""Error of the force sensing that a share of 1 stands for (Xue et al., Section VII)."""
LEAST_FORCE_N = 1e-3
"""A finger that presses less has no sensed force to speak of."""
SHARE_MAX = 2.0
"""Largest share tried: beyond it the direction is off by more than 60 degrees."""

Fields = dict[str, Array]


@dataclass(frozen=True, eq=False)
class RobustMargins(FrozenArrays):
    """Errors that B grasps absorb, each with all the rest as assumed; NaN where infeasible.

    Attributes:
        friction_drop: (B,) 1 - s with the smallest factor s of all friction coefficients for
            which forces exist [-]: equals the best smallest friction margin of any allocation.
            Negative where friction has to grow, minus infinity where that does not help.
        finger_friction_drop: (B,) the same for the fingers' friction alone.
        table_friction_drop: (B,) the same for the table's friction alone; NaN without a table.
        torsion_drop: (B,) the same for the torsional friction of soft fingertips alone; NaN for
            points.
        mass_increase: (B,) largest relative error e >= 0 of the mass, the load being (1 + e) times
            the assumed one [-]; at most 9.
        mass_decrease: (B,) the same for a lighter tool; at most 1, no load at all.
        lift_off_N: (B,) how far above its lower bound the fingers can press the tip on the table
            [N]: the reserve against its lifting off.
        sensing_share: (B,) how much of an error of 25 % in size and 30 degrees in direction of
            one finger's sensed force the other contacts make up for [-]; at most 2. See
            :func:`sensing_share`.
        torque_drop: (B,) 1 - s with the smallest factor s of the joints' torque limits, or
            whatever two-sided rows the grasps have [-]; negative where they have to grow, NaN
            without rows.
    """

    friction_drop: Array
    finger_friction_drop: Array
    table_friction_drop: Array
    torsion_drop: Array
    mass_increase: Array
    mass_decrease: Array
    lift_off_N: Array
    sensing_share: Array
    torque_drop: Array


def robust_margins(grasps: Grasps, force: Array | None = None) -> RobustMargins:
    """Robust margins of B grasps, by bisection on exact verdicts, all of them in one batch.

    Args:
        grasps: B grasps of one shape.
        force: (B, m, 3) nominal forces [N] for ``sensing_share``; else those that leave every
            limit the most room.
    """
    table = np.array([name == PIVOT for name in grasps.names])
    wanted = static_verdicts(grasps, exact=True).force if force is None else force
    low, high = grasps.problem.normal_min, grasps.problem.normal_max
    top = np.where(np.isfinite(high), high, low + 100.0)
    # Bounds that meet would make another program: stop just before.
    near = 1e-6 * (top - low)
    strong, weak = np.log(LARGEST_FACTOR), np.log(LEAST_FACTOR)
    errors: list[_Error] = [
        _FrictionFactor(strong, weak, np.ones_like(table)),
        _FrictionFactor(strong, weak, ~table),
        _FrictionFactor(strong, weak, table),
        _MassError(0.0, HEAVIER - 1.0),
        _MassError(0.0, -1.0),
    ]
    errors += [_AtLeast(low[:, i], (top - near)[:, i], i) for i in range(len(table))]
    errors += [_AtMost(top[:, i], (low + near)[:, i], i) for i in np.nonzero(~table)[0].tolist()]
    rows = grasps.problem.rows
    limited = rows is not None and rows.count > 0
    if limited:
        errors.append(_RowFactor(strong, weak))
    edges = _edges(grasps, errors)
    most, rest = np.split(edges[5:], [len(table)])
    least = rest[: int((~table).sum())]
    nothing = np.full(grasps.count, np.nan)
    return RobustMargins(
        friction_drop=drop_of(edges[0]),
        finger_friction_drop=drop_of(edges[1]),
        table_friction_drop=drop_of(edges[2]),
        torsion_drop=nothing,
        mass_increase=edges[3],
        mass_decrease=np.abs(edges[4]),
        lift_off_N=(most - low.T)[table].sum(axis=0) if table.any() else nothing,
        sensing_share=_sensing_share(grasps, wanted, ~table, least, most[~table]),
        torque_drop=drop_of(edges[-1]) if limited else nothing,
    )


def friction_drop(grasps: Grasps) -> Array:
    """(B,) the ``friction_drop`` of :class:`RobustMargins` alone; also for infeasible grasps."""
    every = np.ones(len(grasps.names), dtype=bool)
    factor = _FrictionFactor(np.log(LARGEST_FACTOR), np.log(LEAST_FACTOR), every)
    return drop_of(_edges(grasps, [factor])[0])


def drop_of(logarithm: Array) -> Array:
    """Relative loss of a limit from the logarithm of the least factor that suffices."""
    drop = np.where(logarithm <= np.log(LEAST_FACTOR), 1.0, 1.0 - np.exp(logarithm))
    return np.where(np.isnan(logarithm), -np.inf, drop)


def sensing_share(slope: Array, wanted: Array, low: Array, high: Array) -> Array:
    """Share of the standard sensing error that one finger's contact can have.

    A controller holds the sensed normal force of a finger at its wanted value f_n. Where size and
    direction are sensed wrongly by 25 s % and d = 30 s degrees, the true one lies between
    f_n (1 - 0.25 s)(cos d - a sin d) and f_n (1 + 0.25 s)(cos d + a sin d), with the slope a =
    |f_t| / f_n. The table and the other fingers, whose forces are free within cones and bounds,
    must hold the tool with any of these. The normal forces that they can match form an interval,
    so that its ends suffice.

    Args:
        slope: (B,) |f_t| / f_n of the wanted force.
        wanted: (B,) its f_n [N].
        low: (B,) least normal force that the others can match [N].
        high: (B,) the largest [N].

    Returns:
        (B,) the largest s, at most :data:`SHARE_MAX`.
    """
    share = np.linspace(0.0, SHARE_MAX, 2001)[:, None]
    angle, error = share * ANGLE_ERROR_RAD, share * SIZE_ERROR
    cosine, sine = np.cos(angle), np.sin(angle)
    most = np.maximum.accumulate((1.0 + error) * (cosine + slope * sine), axis=0)
    least = np.minimum.accumulate((1.0 - error) * (cosine - slope * sine), axis=0)
    slack = 1e-5 * high
    kept = (most * wanted <= high + slack) & (least * wanted >= low - slack)
    steps = np.where(kept.all(axis=0), len(share), np.argmin(kept, axis=0)) - 1
    return np.asarray(share[np.maximum(steps, 0), 0])


def _sensing_share(
    grasps: Grasps, force: Array, fingers: NDArray[np.bool_], low: Array, high: Array
) -> Array:
    """(B,) least share of all fingers that press and are on no ramp; NaN without forces."""
    normal, tangent = split_force(force, grasps.problem.normals)
    least = np.where(np.isfinite(normal).all(axis=1), SHARE_MAX, np.nan)
    free = np.isnan(grasps.problem.fixed) & (np.nan_to_num(normal) > LEAST_FORCE_N)
    for finger, lower, upper in zip(np.nonzero(fingers)[0], low, high, strict=True):
        at = np.nonzero(free[:, finger])[0]
        wanted = normal[at, finger]
        found = sensing_share(tangent[at, finger] / wanted, wanted, lower[at], upper[at])
        least[at] = np.minimum(least[at], found)
    return least


@dataclass(frozen=True, eq=False)
class _Error(ABC):
    """An error in the data: a family of grasps with one number each, from ``start`` on."""

    start: Array | float
    limit: Array | float

    @abstractmethod
    def apply(self, fields: Fields, value: Array) -> None:
        """Change the fields (N, ...) of the trials with these values (N,)."""


@dataclass(frozen=True, eq=False)
class _FrictionFactor(_Error):
    """Logarithm of a factor of the friction of some contacts (m,)."""

    whose: NDArray[np.bool_]

    def apply(self, fields: Fields, value: Array) -> None:
        fields["friction"] *= np.where(self.whose, np.exp(value)[:, None], 1.0)


@dataclass(frozen=True, eq=False)
class _MassError(_Error):
    """Relative error of the load."""

    def apply(self, fields: Fields, value: Array) -> None:
        fields["wrench"] *= 1.0 + value[:, None]


@dataclass(frozen=True, eq=False)
class _AtLeast(_Error):
    """Least normal force of a contact, unless it is on a ramp."""

    contact: int

    def apply(self, fields: Fields, value: Array) -> None:
        _bound(fields, "normal_min", self.contact, value)


@dataclass(frozen=True, eq=False)
class _AtMost(_Error):
    """Largest normal force of a contact, unless it is on a ramp."""

    contact: int

    def apply(self, fields: Fields, value: Array) -> None:
        _bound(fields, "normal_max", self.contact, value)


@dataclass(frozen=True, eq=False)
class _RowFactor(_Error):
    """Logarithm of a factor of the distance between the limits of rows, about their middle."""

    def apply(self, fields: Fields, value: Array) -> None:
        lower, upper = fields["lower"], fields["upper"]
        two_sided = np.isfinite(lower) & np.isfinite(upper)
        bounded = np.where(two_sided, 0.5 * (upper - lower), 0.0)
        change = (np.exp(value)[:, None] - 1.0) * bounded
        fields["lower"], fields["upper"] = lower - change, upper + change


def _bound(fields: Fields, name: str, contact: int, value: Array) -> None:
    free = np.isnan(fields["normal_fixed"][:, contact])
    fields[name][free, contact] = value[free]


def _edges(grasps: Grasps, errors: list[_Error]) -> Array:
    """(errors, B) how far each error can go; all errors of all grasps are one batch of lines."""
    count, problem = grasps.count, grasps.problem

    def holds(line: Index, value: Array) -> NDArray[np.bool_]:
        grasp = line % count
        fields = {
            "friction": grasps.friction[grasp],
            "wrench": problem.wrench[grasp],
            "normal_min": problem.normal_min[grasp],
            "normal_max": problem.normal_max[grasp],
            "normal_fixed": problem.fixed[grasp],
        }
        rows = problem.rows
        if rows is not None:
            fields |= {"lower": rows.lower[grasp], "upper": rows.upper[grasp]}
        for place, error in enumerate(errors):
            mine = np.nonzero(line // count == place)[0]
            part = {name: array[mine] for name, array in fields.items()}
            error.apply(part, value[mine])
            for name, array in part.items():
                fields[name][mine] = array
        if rows is None:
            changed = grasps.take(grasp).changed(**fields)
        else:
            limits = LinearRows(rows.matrix[grasp], fields.pop("lower"), fields.pop("upper"))
            changed = grasps.take(grasp).changed(rows=limits, **fields)
        return static_verdicts(changed).feasible

    start, limit = (
        np.concatenate([np.broadcast_to(getattr(error, end), count) for error in errors])
        for end in ("start", "limit")
    )
    return last_feasible(start, limit, holds, rounds=9).reshape(len(errors), count)
