"""What a run left beside its plan: planning times and closed-loop trials."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, FiniteFloat, ValidationError

from pivotgait.exceptions import InputError
from pivotgait.reporting.numbers import number, quantity


class PhaseSummary(BaseModel):
    """A phase, as ``pivotgait plan --json`` lists it."""

    name: str
    plan_time_s: FiniteFloat | None = None
    reorientation_deg: FiniteFloat | None = None
    solver: str = ""
    iterations: int | None = None
    kkt_residual: FiniteFloat | None = None
    smallest_static_turn_deg: FiniteFloat | None = None
    static_without_turning: bool | None = None
    nodes: int | None = None
    length_found_m: FiniteFloat | None = None
    length_m: FiniteFloat | None = None

    @property
    def note(self) -> str:
        """A sentence or two about how a removal or a relocation was found; else empty."""
        return self._relocation_note or self._removal_note

    @property
    def _relocation_note(self) -> str:
        if self.length_found_m is None or self.length_m is None:
            return ""
        found, kept = (quantity(1e3 * x, "mm") for x in (self.length_found_m, self.length_m))
        return (
            f"Found by {self.solver} with {number(self.iterations)} samples and "
            f"{number(self.nodes)} nodes; shortcuts took the path from {found} to {kept}, "
            "measured as a bound on how far any point of the hand moves."
        )

    @property
    def _removal_note(self) -> str:
        """Whether the turn was needed, and how near the solver came to an optimum."""
        if self.smallest_static_turn_deg is None or self.static_without_turning is None:
            return ""
        need = (
            "The other contacts could hold the tool at rest without turning it."
            if self.static_without_turning
            else "Without turning, the other contacts cannot hold the tool at rest: they need at "
            f"least {self.smallest_static_turn_deg:.2f}°."
        )
        turned = quantity(self.reorientation_deg, "°").replace("\N{NO-BREAK SPACE}°", "°")
        return (
            f"{need} The plan turns it by {turned}. Solved by {self.solver} in "
            f"{self.iterations} iterations; the conditions of local optimality hold to "
            f"{number(self.kkt_residual, 2)}."
        )


class Stage(BaseModel):
    """A stage of a trial: how many trials reached and passed it."""

    name: str
    reached: int
    passed: int


class Trials(BaseModel):
    """Closed-loop trials, as ``pivotgait validate --json`` counts them."""

    simulator: str
    controller: str
    pivoting: bool = True
    trials: int
    passed: int
    rate: FiniteFloat | None = None
    wilson_95: tuple[FiniteFloat, FiniteFloat] | None = None
    stages: tuple[Stage, ...] = ()
    failures: Mapping[str, int] = {}


class Summary(BaseModel):
    """``summary.json``: the output of ``pivotgait plan --json``, and of validations if there are.

    Keys that the report does not show are welcome.
    """

    phases: tuple[PhaseSummary, ...] = ()
    validations: tuple[Trials, ...] = ()

    @property
    def plan_times(self) -> Mapping[str, float]:
        """Phase's name -> time to plan it [s]."""
        times = {phase.name: phase.plan_time_s for phase in self.phases}
        return {name: time for name, time in times.items() if time is not None}

    @property
    def notes(self) -> Mapping[str, str]:
        """Phase's name -> a sentence or two about its making."""
        return {phase.name: phase.note for phase in self.phases if phase.note}


def read_summary(path: Path) -> Summary:
    """The summary in ``path``; an empty one if there is no such file.

    Raises:
        InputError: if the file cannot be read or is no summary.
    """
    if not path.is_file():
        return Summary()
    mend = "write it anew with pivotgait plan --json, or remove it"
    try:
        return Summary.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=path.name, mend=mend) from error
    except ValidationError as error:
        raise InputError(f"is no summary: {_first(error)}", where=path.name, mend=mend) from error


def trials_of(summary: Mapping[str, Any], *, where: str) -> Trials:
    """Trials from what their record says of them.

    Raises:
        InputError: if it does not say enough.
    """
    try:
        return Trials.model_validate(summary)
    except ValidationError as error:
        what, mend = f"is no record of trials: {_first(error)}", "write it anew"
        raise InputError(what, where=where, mend=mend) from error


def _first(error: ValidationError) -> str:
    found: Any = error.errors(include_url=False)[0]
    place = ".".join(str(part) for part in found["loc"])
    return f"{place}: {found['msg']}" if place else str(found["msg"])
