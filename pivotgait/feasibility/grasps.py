"""Many grasps of one shape at once: what a verdict is asked about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import InputError
from pivotgait.forces import AllocationProblem, LinearRows
from pivotgait.frozen import Array, frozen
from pivotgait.plans import PIVOT

Index = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Grasps:
    """B grasps with the same contacts, each with its own places, limits and load.

    Attributes:
        problem: B samples (places, normals, bounds, wrench, ramps, rows); its objective plays no
            role, and its friction is that of the first grasp.
        friction: (B, m) Coulomb coefficients.

    Raises:
        InputError: samples that depend on one another; friction of a wrong shape or not positive.
    """

    problem: AllocationProblem
    friction: Array

    def __post_init__(self) -> None:
        problem, friction = self.problem, frozen(self.friction)
        if problem.coupled:
            raise InputError("grasps are judged one by one", mend="leave start, end and rate out")
        if friction.shape != (problem.samples, problem.contacts):
            mend = f"expected {(problem.samples, problem.contacts)}"
            raise InputError(f"friction has shape {friction.shape}", mend=mend)
        if not np.all(np.isfinite(friction) & (friction > 0.0)):
            raise InputError("friction is not positive and finite", mend="give coefficients > 0")
        object.__setattr__(self, "friction", friction)

    @classmethod
    def of(cls, problem: AllocationProblem) -> Grasps:
        """The samples of an allocation problem, freed of what couples them."""
        free = replace(problem, start=None, end=None, force_rate_max=None, objective="effort")
        shape = (problem.samples, problem.contacts)
        return cls(free, np.broadcast_to(problem.friction, shape))

    @classmethod
    def resting(
        cls,
        names: Sequence[str],
        rotation: Array,
        pivot_in_tool: Array,
        points: Array,
        inward: Array,
        weight: Array,
        *,
        friction: Array,
        normal_min: Array,
        normal_max: Array,
    ) -> Grasps:
        """Tools that rest on their pivot, held by fingers.

        Every array may leave its leading B out where all grasps share it.

        Args:
            names: of the n fingers.
            rotation: (B, 3, 3) world <- tool.
            pivot_in_tool: (3,) tool frame, from the centre of mass [m].
            points: (B, n, 3) finger contacts, tool frame, from the centre of mass [m].
            inward: (B, n, 3) unit inward normals there, tool frame.
            weight: (B, 3) gravity force on the tool, world [N].
            friction: (B, 1 + n) of pivot and fingers.
            normal_min: (B, 1 + n) least normal forces [N].
            normal_max: (B, 1 + n) largest normal forces [N].
        """
        n = len(names)
        trailing = ((3, 3), (n, 3), (n, 3), (3,), (1 + n,), (1 + n,), (1 + n,))
        given = (rotation, points, inward, weight, friction, normal_min, normal_max)
        count = max(
            len(a) if np.ndim(a) > len(t) else 1 for a, t in zip(given, trailing, strict=True)
        )
        turn, at, into, load, mu, low, high = (
            np.broadcast_to(a, (count, *t)) for a, t in zip(given, trailing, strict=True)
        )
        pivot = np.broadcast_to(pivot_in_tool, (count, 1, 3))
        back = np.swapaxes(turn, 1, 2)
        normals = np.zeros((count, 1 + n, 3))
        normals[:, 0, 2] = 1.0
        normals[:, 1:] = into @ back
        problem = AllocationProblem(
            names=(PIVOT, *names),
            lever=np.concatenate((pivot, at), axis=1) @ back,
            normals=normals,
            friction=mu[0],
            normal_min=low,
            normal_max=high,
            wrench=np.concatenate((-load, np.zeros((count, 3))), axis=1),
            objective="effort",
        )
        return cls(problem, mu)

    @classmethod
    def joined(cls, parts: Sequence[Grasps]) -> Grasps:
        """Several batches without rows and with the same contacts, one after the other.

        Raises:
            InputError: none, other contacts, or rows.
        """
        if len({each.names for each in parts}) != 1 or any(p.problem.rows for p in parts):
            raise InputError("grasps are not of one shape", mend="join those of the same contacts")
        fields = ("lever", "normals", "normal_min", "normal_max", "wrench")
        joined: dict[str, Any] = {
            name: np.concatenate([getattr(each.problem, name) for each in parts]) for name in fields
        }
        friction = np.concatenate([each.friction for each in parts])
        fixed = np.concatenate([each.problem.fixed for each in parts])
        first = parts[0].problem
        return cls(replace(first, friction=friction[0], normal_fixed=fixed, **joined), friction)

    @property
    def count(self) -> int:
        """Number of grasps B."""
        return self.problem.samples

    @property
    def names(self) -> tuple[str, ...]:
        """The m contacts."""
        return self.problem.names

    def take(self, index: Index) -> Grasps:
        """The grasps at ``index``, which may name one several times."""
        p, rows = self.problem, self.problem.rows
        cut: dict[str, Any] = {
            name: getattr(p, name)[index]
            for name in ("lever", "normals", "normal_min", "normal_max", "wrench")
        }
        if rows is not None:
            cut["rows"] = LinearRows(rows.matrix[index], rows.lower[index], rows.upper[index])
        friction = self.friction[index]
        problem = replace(p, friction=friction[0], normal_fixed=p.fixed[index], **cut)
        return Grasps(problem, friction)

    def changed(self, *, friction: Array | None = None, **limits: Array | LinearRows) -> Grasps:
        """These grasps with other friction (B, m) or other fields of the problem."""
        mu = self.friction if friction is None else np.asarray(friction)
        values: dict[str, Any] = limits
        return Grasps(replace(self.problem, friction=mu[0], **values), mu)
