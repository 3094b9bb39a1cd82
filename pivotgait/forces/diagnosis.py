"""Why a sample has no contact forces, and the smallest changes that would give it some."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces.local_form import LocalForm, local_form
from pivotgait.forces.null_space import Inconsistent, reduce
from pivotgait.forces.problem import AllocationProblem

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Kind = Literal["none", "friction", "normal_max", "normal_min", "rows", "wrench", "coupling"]
Change = Literal["friction", "friction_scale", "normal_max", "normal_max_scale", "normal_min"]
PIVOT = "pivot"
REACH = 30.0
"""Mends beyond this factor are not offered: no finger has thirty times the friction."""
HALVINGS = 36
"""Of a bracket of ln(1e3): leaves a relative error near 1e-11, below the solver's own 1e-9."""
DIGITS = 4
"""Mends are rounded, to the feasible side, to this many significant digits for reading."""


@dataclass(frozen=True)
class Mend:
    """The smallest change of one limit that makes a sample feasible.

    Attributes:
        change: what to change; the ``_scale`` ones multiply the limit of all fingers alike.
        contact: whose; ``"fingers"`` for all of them.
        from_: the value now (1 for a scale).
        to: the value that suffices, rounded to the feasible side.
    """

    change: Change
    contact: str
    from_: float
    to: float

    def applied_to(self, problem: AllocationProblem) -> AllocationProblem:
        """The problem with this change made at every sample."""
        mine = [i for i, name in enumerate(problem.names) if self._means(name)]
        limit = self.change.removesuffix("_scale")
        value = np.array(getattr(problem, limit))
        scaled = self.change.endswith("_scale")
        value[..., mine] = value[..., mine] * self.to if scaled else self.to
        changes: dict[str, Any] = {limit: value}
        return replace(problem, **changes)

    def text(self) -> str:
        """One phrase, e.g. ``friction of thumb from 0.8 to 0.913``."""
        unit = " N" if self.change in ("normal_max", "normal_min") else ""
        name = self.change.replace("_", " ")
        return f"{name} of {self.contact} from {self.from_:.4g}{unit} to {self.to:.4g}{unit}"

    def _means(self, name: str) -> bool:
        return name != PIVOT if self.contact == "fingers" else name == self.contact


@dataclass(frozen=True)
class Diagnosis:
    """What binds at a sample.

    Attributes:
        sample: its index.
        kind: the limit with the largest multiplier of the smallest common relaxation; ``wrench``
            if no forces of any size apply the wrench, ``coupling`` if the sample alone is
            feasible and its neighbours or prescribed end forces forbid it, ``none`` if feasible.
        contact: whose limit; the row's index for ``rows``; empty for the others.
        violation: the smallest common relaxation of all limits that gives forces [N].
        mends: changes of one limit each that suffice, the smallest relative change first.
        duration: for ``coupling``, the least time [s] from ``start`` to ``end`` at the force
            rate; 0 if there are not both and a rate.
    """

    sample: int
    kind: Kind
    contact: str
    violation: float
    mends: tuple[Mend, ...]
    duration: float = 0.0

    def text(self) -> str:
        """One sentence on what binds."""
        where = f"at sample {self.sample}"
        if self.kind == "none":
            return f"nothing binds {where}"
        if self.kind == "wrench":
            return f"{where} these contacts cannot apply the wrench ({self.violation:.3g} N short)"
        if self.kind == "coupling":
            needs = f"; from start to end needs at least {self.duration:.4g} s"
            forbid = f"{where} alone there are forces: start, end or force rate forbid them"
            return forbid + (needs if self.duration > 0.0 else "")
        whose = f" of {self.contact}" if self.contact else ""
        return f"{where} {self.kind}{whose} binds ({self.violation:.3g} N short)"

    def mend_text(self) -> str:
        """The mends in words."""
        if self.kind == "coupling":
            return "allow more time" + (f", {self.duration:.4g} s or more" * (self.duration > 0.0))
        if not self.mends:
            return "move or add a contact"
        return "change " + ", or ".join(mend.text() for mend in self.mends[:3])


def diagnose(problem: AllocationProblem, sample: int) -> Diagnosis:
    """Find what binds at one sample, and the smallest single changes that would mend it.

    Args:
        problem: T samples.
        sample: index of the one to explain.
    """
    from pivotgait.forces.phase_one import FEASIBLE, phase_one

    single = problem.sample(sample)
    group = next(reduce(local_form(single), single.wrench, single.friction[None]))
    if isinstance(group, Inconsistent):
        return Diagnosis(sample, "wrench", "", float(group.residual[0]), ())
    relaxed = phase_one(group.cones, exact=True)
    shift = float(relaxed.shift[0])
    if shift <= FEASIBLE:
        kind: Kind = "coupling" if problem.coupled else "none"
        return Diagnosis(sample, kind, "", 0.0, (), _least_duration(problem))
    cone, scalar = group.cones.split(relaxed.dual)
    weight = np.concatenate((cone[2, :, 0], scalar[:, 0]))
    label, index = group.labels[int(np.argmax(weight))]
    contact = str(index) if label == "rows" else problem.names[index]
    violation = shift * float(group.scale[0])
    return Diagnosis(sample, cast(Kind, label), contact, violation, _mends(single))


def _least_duration(problem: AllocationProblem) -> float:
    """Time [s] that the contact with the largest change from start to end takes at the rate."""
    start, end, rate = problem.start, problem.end, problem.force_rate_max
    if start is None or end is None or rate is None:
        return 0.0
    return float(np.linalg.norm(end - start, axis=1).max() / rate)


def _mends(problem: AllocationProblem) -> tuple[Mend, ...]:
    """Bisect all candidate changes at once, each a sample of one batch."""
    form = local_form(problem)
    now: list[tuple[Change, str, float]] = []
    for i, name in enumerate(problem.names):
        if problem.loaded[0, i]:
            now.append(("friction", name, float(problem.friction[i])))
        if np.isfinite(form.high[0, i]):
            now.append(("normal_max", name, float(form.high[0, i])))
        if np.isfinite(form.low[0, i]):
            now.append(("normal_min", name, float(form.low[0, i])))
    if sum(name != PIVOT for name in problem.names) > 1:
        now += [("friction_scale", "fingers", 1.0), ("normal_max_scale", "fingers", 1.0)]

    def mend(entry: tuple[Change, str, float], share: float) -> Mend:
        change, name, value = entry
        to = value * (1.0 - share) if change == "normal_min" else value * REACH**share
        return Mend(change, name, value, to)

    low, high = np.zeros(len(now)), np.ones(len(now))
    possible = _feasible(problem, form, [mend(entry, 1.0) for entry in now])
    now = [entry for entry, can in zip(now, possible, strict=True) if can]
    low, high = low[possible], high[possible]
    for _ in range(HALVINGS if now else 0):
        middle = 0.5 * (low + high)
        trials = [mend(entry, share) for entry, share in zip(now, middle, strict=True)]
        enough = _feasible(problem, form, trials)
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    found = [_rounded(mend(entry, share)) for entry, share in zip(now, high, strict=True)]
    return tuple(sorted(found, key=lambda m: abs(m.to - m.from_) / m.from_))


def _rounded(mend: Mend) -> Mend:
    if mend.to <= 1e-9 * mend.from_:
        return replace(mend, to=0.0)
    unit = 10.0 ** (np.floor(np.log10(mend.to)) - DIGITS + 1)
    steps = np.floor(mend.to / unit) if mend.change == "normal_min" else np.ceil(mend.to / unit)
    return replace(mend, to=float(f"{steps * unit:.{DIGITS}g}"))


def _feasible(problem: AllocationProblem, form: LocalForm, mends: list[Mend]) -> Mask:
    """(len(mends),) whether the single sample is feasible under each change."""
    from pivotgait.forces.phase_one import FEASIBLE, phase_one

    count = len(mends)

    def repeated(value: NDArray[Any]) -> NDArray[Any]:
        return np.repeat(value, count, axis=0)

    friction = repeated(problem.friction[None])
    limits = {"friction": friction, "normal_max": repeated(form.high)}
    limits["normal_min"] = repeated(form.low)
    for row, mend in enumerate(mends):
        limit = limits[mend.change.removesuffix("_scale")][row]
        for i, name in enumerate(problem.names):
            if mend._means(name):
                limit[i] = limit[i] * mend.to if mend.change.endswith("_scale") else mend.to
    low = limits["normal_min"]
    many = LocalForm(
        frames=repeated(form.frames),
        grasp=repeated(form.grasp),
        rows=repeated(form.rows),
        lower=repeated(form.lower),
        upper=repeated(form.upper),
        known=repeated(form.known),
        value=repeated(form.value),
        low=np.where(low > 0.0, low, np.nan),
        high=limits["normal_max"],
    )
    out = np.zeros(count, dtype=bool)
    for group in reduce(many, repeated(problem.wrench), friction):
        if not isinstance(group, Inconsistent):
            out[group.index] = phase_one(group.cones).shift <= FEASIBLE
    return out
