"""The records of a certification: findings, violations and the certificate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pivotgait.certification.limits import Limit
from pivotgait.plans import Phase


@dataclass(frozen=True)
class Finding:
    """A residual and where it was found.

    Attributes:
        what: key of the limit that judges it.
        value: in the limit's unit.
        phase: name of the phase, empty for the plan as a whole.
        contact: name of the contact, empty where there is none.
        time_s: from the phase's start, None where it does not depend on time.
        part: of the robot: a joint or a pair of links, empty where there is none.
    """

    what: str
    value: float
    phase: str = ""
    contact: str = ""
    time_s: float | None = None
    part: str = ""

    def place(self) -> dict[str, Any]:
        """Where it was found, as plain data; the robot's part only if there is one."""
        found = {"phase": self.phase, "contact": self.contact, "time_s": self.time_s}
        return {**found, "part": self.part} if self.part else found


@dataclass(frozen=True)
class Violation(Finding):
    """A finding beyond its limit.

    Attributes:
        limit: the bound that it misses.
    """

    limit: float = math.nan

    def as_json(self) -> dict[str, Any]:
        """Plain data for a file or the command line."""
        return {
            "phase": self.phase,
            "what": self.what,
            "value": _plain(self.value),
            "limit": self.limit,
            **self.place(),
        }


@dataclass(frozen=True, eq=False)
class Certificate:
    """What a plan file says of itself when it is recomputed.

    Attributes:
        findings: the worst finding of each residual, over phases, contacts and time.
        violations: every check that fails: one for each residual, phase and contact.
        limits: by which the plan was judged.
    """

    findings: Mapping[str, Finding]
    violations: tuple[Violation, ...]
    limits: Mapping[str, Limit]

    @property
    def valid(self) -> bool:
        """Whether the plan keeps every limit."""
        return not self.violations

    @property
    def residuals(self) -> Mapping[str, float]:
        """Residual's name -> worst value in the plan."""
        return MappingProxyType({what: found.value for what, found in self.findings.items()})

    def as_json(self) -> dict[str, Any]:
        """Plain data for the plan file and ``pivotgait certify --json``."""
        return {
            "valid": self.valid,
            "residuals": {what: _plain(value) for what, value in self.residuals.items()},
            "violations": [violation.as_json() for violation in self.violations],
            "tolerances": {what: self.limits[what].bound for what in self.findings},
            "worst": {what: found.place() for what, found in self.findings.items()},
        }


def judge(findings: Iterable[Finding], limits: Mapping[str, Limit]) -> Certificate:
    """Certificate of all findings of a plan."""
    worst: dict[str, Finding] = {}
    violations = []
    for found in findings:
        limit = limits[found.what]
        if found.what not in worst or _is_worse(found.value, worst[found.what].value, limit):
            worst[found.what] = found
        if not limit.holds(found.value):
            violations.append(Violation(**vars(found), limit=limit.bound))
    return Certificate(MappingProxyType(worst), tuple(violations), limits)


def largest(what: str, values: ArrayLike, phase: Phase, contact: str = "") -> Finding:
    """Finding at the sample with the largest of ``values`` (N,) or (N-1,); NaN is larger still."""
    series = np.asarray(values, dtype=float)
    index = int(np.argmax(series))  # the first NaN, if there is one
    return Finding(what, float(series[index]), phase.name, contact, float(phase.time[index]))


def largest_joint(what: str, values: ArrayLike, phase: Phase, names: Sequence[str]) -> Finding:
    """Finding at the sample and joint with the largest of ``values`` (N or N-1, n)."""
    table = np.asarray(values, dtype=float)
    k, joint = divmod(int(np.argmax(table)), table.shape[1])
    time = float(phase.time[k])
    return Finding(what, float(table[k, joint]), phase.name, time_s=time, part=names[joint])


def smallest(what: str, values: ArrayLike, phase: Phase, contact: str = "") -> Finding:
    """Finding at the sample with the smallest of ``values`` (N,); NaN is smaller still."""
    series = np.asarray(values, dtype=float)
    index = int(np.argmin(series))
    return Finding(what, float(series[index]), phase.name, contact, float(phase.time[index]))


def _is_worse(value: float, than: float, limit: Limit) -> bool:
    if not math.isfinite(than):
        return False
    if not math.isfinite(value):
        return True
    return value < than if limit.at_least else value > than


def _plain(value: float) -> float | None:
    # JSON knows no NaN.
    return value if math.isfinite(value) else None
