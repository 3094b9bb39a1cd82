"""The force allocation problem (Xue et al., eqs 4-8), free of any solver."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import InputError
from pivotgait.frozen import frozen

Array = NDArray[np.float64]
Objective = Literal["alignment", "tangential", "effort", "margin"]
OBJECTIVES: tuple[str, ...] = get_args(Objective)
MARGIN_SLACK = 1e-5
"""``margin`` gives up this much of the best margin, so that its tie-break has an interior."""
UNIT_TOLERANCE = 1e-6
"""Normals may be this far from unit length: rounded files, not wrong data."""
FIXED_TOLERANCE = 1e-6
"""A ramp value may pass its bound by this [N]: it came from an earlier solve."""


def _freeze(record: Any) -> None:
    for entry in fields(record):
        value = getattr(record, entry.name)
        if isinstance(value, np.ndarray | list):
            object.__setattr__(record, entry.name, frozen(value))


@dataclass(frozen=True, eq=False)
class LinearRows:
    """Rows lower <= matrix @ f <= upper on the stacked forces, e.g. joint torque limits.

    Attributes:
        matrix: (T, r, 3 m), forces stacked contact by contact in the problem's frame.
        lower: (T, r), ``-inf`` where there is no lower limit.
        upper: (T, r), ``inf`` where there is no upper limit.
    """

    matrix: Array
    lower: Array
    upper: Array

    def __post_init__(self) -> None:
        _freeze(self)

    @property
    def count(self) -> int:
        """Number of rows r."""
        return int(self.matrix.shape[1])


@dataclass(frozen=True, eq=False)
class AllocationProblem:
    """T samples of one shape: which contact forces apply the wrench, and which of them is best.

    Every vector is in one common frame (usually the world). Objectives, summed over contacts:
    ``alignment`` minimises sin^2 of the angle between force and normal (eq. 4),
    ``tangential`` |f_t|^2 / f_n, ``effort`` |f|^2, and ``margin`` maximises the smallest
    1 - |f_t| / (mu f_n), ties broken by ``tangential``.

    Attributes:
        names: the m contacts.
        lever: (T, m, 3) contact points relative to the centre of mass [m].
        normals: (T, m, 3) inward unit normals.
        friction: (m,) Coulomb coefficients, > 0 (eq. 5).
        normal_min: (T, m) lower bounds of the normal force [N] (eq. 6).
        normal_max: (T, m) upper bounds [N]; ``inf`` means none.
        wrench: (T, 6) force [N] and moment about the centre of mass [N m] that the contacts
            together apply (right-hand sides of eq. 3).
        normal_fixed: (T, m) prescribed normal force [N] of a finger that comes or goes
            (eqs 7 and 8), NaN where free. Where 0, the whole force is 0 and the contact has
            no part in the objective. None: all free.
        rows: further linear rows, or None.
        start: (m, 3) forces prescribed at the first sample [N], or None.
        end: (m, 3) forces prescribed at the last sample [N], or None.
        force_rate_max: bound of |f_k - f_(k-1)| / step_s per contact [N/s], or None.
        step_s: time between samples [s]; needed with ``force_rate_max``.
        objective: one of :data:`OBJECTIVES`.

    Raises:
        InputError: a shape, value or name that cannot be; says which contact and where.
    """

    names: tuple[str, ...]
    lever: Array
    normals: Array
    friction: Array
    normal_min: Array
    normal_max: Array
    wrench: Array
    normal_fixed: Array | None = None
    rows: LinearRows | None = None
    start: Array | None = None
    end: Array | None = None
    force_rate_max: float | None = None
    step_s: float | None = None
    objective: Objective = "alignment"

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(self.names))
        _freeze(self)
        if self.normal_fixed is None:
            object.__setattr__(self, "normal_fixed", frozen(np.full(self.normal_min.shape, np.nan)))
        self._check_shapes()
        self._check_values()

    @property
    def samples(self) -> int:
        """Number of samples T."""
        return int(self.wrench.shape[0])

    @property
    def contacts(self) -> int:
        """Number of contacts m."""
        return len(self.names)

    @property
    def coupled(self) -> bool:
        """Whether samples depend on one another or on prescribed end forces."""
        return not (self.start is None and self.end is None and self.force_rate_max is None)

    def sample(self, k: int) -> AllocationProblem:
        """Sample k alone, without what couples it to the others."""
        cut = slice(k, k + 1)
        rows = self.rows
        return replace(
            self,
            lever=self.lever[cut],
            normals=self.normals[cut],
            normal_min=self.normal_min[cut],
            normal_max=self.normal_max[cut],
            wrench=self.wrench[cut],
            normal_fixed=self.fixed[cut],
            rows=rows and LinearRows(rows.matrix[cut], rows.lower[cut], rows.upper[cut]),
            start=None,
            end=None,
            force_rate_max=None,
        )

    @property
    def fixed(self) -> Array:
        """(T, m) prescribed normal forces [N], NaN where free."""
        assert self.normal_fixed is not None
        return self.normal_fixed

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """(T, m) whether the contact may carry a force: its normal force is not fixed at 0."""
        return np.asarray(self.fixed != 0.0)

    def _check_shapes(self) -> None:
        if self.wrench.ndim != 2 or self.wrench.shape[0] == 0:
            raise InputError(f"wrench has shape {self.wrench.shape}", mend="give (T, 6), T >= 1")
        t, m = self.samples, self.contacts
        if m == 0 or len(set(self.names)) != m:
            raise InputError(f"contact names {self.names}", mend="give distinct names")
        wanted: dict[str, tuple[int, ...]] = {
            "wrench": (t, 6),
            "lever": (t, m, 3),
            "normals": (t, m, 3),
            "friction": (m,),
            "normal_min": (t, m),
            "normal_max": (t, m),
            "normal_fixed": (t, m),
            "start": (m, 3),
            "end": (m, 3),
        }
        for name, shape in wanted.items():
            value = getattr(self, name)
            if value is not None and value.shape != shape:
                raise InputError(
                    f"{name} has shape {value.shape}", mend=f"expected {shape} for {self.names}"
                )
        if self.rows is not None:
            r = self.rows.count
            shapes = (self.rows.matrix.shape, self.rows.lower.shape, self.rows.upper.shape)
            if shapes != ((t, r, 3 * m), (t, r), (t, r)):
                raise InputError(
                    f"rows have shapes {shapes}", mend=f"expected ({t}, r, {3 * m}) and ({t}, r)"
                )
        if self.objective not in OBJECTIVES:
            raise InputError(
                f"unknown objective {self.objective!r}", mend=f"known: {', '.join(OBJECTIVES)}"
            )

    def _check_values(self) -> None:
        for name in ("lever", "normals", "friction", "normal_min", "wrench", "start", "end"):
            value = getattr(self, name)
            if value is not None and not np.all(np.isfinite(value)):
                raise InputError(f"{name} is not finite", where=self._first(~np.isfinite(value)))
        length = np.linalg.norm(self.normals, axis=-1)
        self._refuse(np.abs(length - 1.0) > UNIT_TOLERANCE, "normal is not of unit length", length)
        self._refuse(~(self.friction > 0.0)[None], "friction is not positive", self.friction[None])
        self._refuse(self.normal_min < 0.0, "normal_min is negative [N]", self.normal_min)
        self._refuse(
            ~(self.normal_min <= self.normal_max), "normal_max < normal_min [N]", self.normal_max
        )
        fixed = self.fixed
        low, high = self.normal_min - FIXED_TOLERANCE, self.normal_max + FIXED_TOLERANCE
        self._refuse(
            (fixed < 0.0) | (fixed < low) | (fixed > high) | np.isinf(fixed),
            "normal_fixed is outside its bounds [N] (a ramping finger has normal_min 0)",
            fixed,
        )
        if self.rows is not None:
            rows = self.rows
            if not (np.all(np.isfinite(rows.matrix)) and np.all(rows.lower <= rows.upper)):
                raise InputError("rows are not finite, or a lower limit exceeds its upper limit")
        if self.force_rate_max is not None:
            step = self.step_s
            if not (np.isfinite(self.force_rate_max) and self.force_rate_max > 0.0):
                raise InputError(f"force_rate_max is {self.force_rate_max} N/s", mend="give > 0")
            if step is None or not (np.isfinite(step) and step > 0.0):
                raise InputError(f"step_s is {step} s", mend="a force rate needs a time step > 0")
        unbounded = np.isinf(self.normal_max) & np.isnan(fixed)
        if self.objective != "effort" and np.any(unbounded.sum(axis=-1) > 1):
            raise InputError(
                f"objective {self.objective!r} would squeeze without limit",
                where=self._first(unbounded & (unbounded.sum(axis=-1, keepdims=True) > 1)),
                mend="give a finite normal_max to all contacts but one",
            )

    def _refuse(self, bad: NDArray[np.bool_], what: str, value: Array) -> None:
        if np.any(bad):
            raise InputError(f"{what}: {value[np.nonzero(bad)][0]:g}", where=self._first(bad))

    def _first(self, bad: NDArray[np.bool_]) -> str:
        """Name the sample and contact of the first True."""
        index = np.argwhere(bad)[0]
        if bad.ndim >= 2 and bad.shape[1] == self.contacts:
            return f"sample {index[0]}, contact {self.names[index[1]]!r}"
        if bad.shape[0] == self.contacts:
            return f"contact {self.names[index[0]]!r}"
        return f"sample {index[0]}"
