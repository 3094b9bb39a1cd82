"""The time axis of a whole gait: phases end to end, shaded and named."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pivotgait.exceptions import UnknownNameError
from pivotgait.plans.plan import GaitPlan, Phase

_SHADES = ("#F1F1EE", "#FFFFFF")
_INCH_PER_LETTER = 0.062


class Span(NamedTuple):
    """A phase and when it starts and ends in the gait [s]."""

    phase: Phase
    start: float
    end: float

    @property
    def time(self) -> NDArray[np.float64]:
        """(N,) seconds from the start of the gait."""
        return np.asarray(self.start + self.phase.time - self.phase.time[0])


class _Stretch(NamedTuple):
    """A named part of the time axis [s]."""

    title: str
    start: float
    end: float


def spans(plan: GaitPlan) -> tuple[Span, ...]:
    """The phases laid end to end."""
    ends = np.cumsum([phase.duration_s for phase in plan.phases])
    starts = np.concatenate(([0.0], ends[:-1]))
    return tuple(
        Span(phase, float(start), float(end))
        for phase, start, end in zip(plan.phases, starts, ends, strict=True)
    )


def find_phase(plan: GaitPlan, name: str) -> Phase:
    """The phase called ``name``.

    Raises:
        UnknownNameError: if the plan has no such phase.
    """
    for phase in plan.phases:
        if phase.name == name:
            return phase
    raise UnknownNameError("phase", name, (phase.name for phase in plan.phases))


def phase_title(phase: Phase) -> str:
    """What happens in a phase, in two words: ``addition middle``."""
    return f"{phase.kind} {phase.finger}".strip()


def shade_phases(
    axes: Any, plan: GaitPlan, *, named: bool = True, end: float | None = None
) -> None:
    """Shade each phase behind ``axes`` and, if ``named``, write its name above it.

    With an ``end`` [s] after the plan's, what lies between is the final hold of a run.
    """
    stretches = [_Stretch(phase_title(span.phase), span.start, span.end) for span in spans(plan)]
    if end is not None and end > stretches[-1].end:
        stretches.append(_Stretch("final hold", stretches[-1].end, end))
    for number, each in enumerate(stretches):
        axes.axvspan(each.start, each.end, color=_SHADES[number % 2], lw=0, zorder=0)
    axes.set_xlim(0.0, stretches[-1].end)
    if named:
        _name(axes, stretches)


def _name(axes: Any, stretches: Sequence[_Stretch]) -> None:
    width = axes.figure.get_figwidth() * 0.85 / stretches[-1].end
    words = [each.title.split() for each in stretches]
    fits = all(
        max(map(len, two)) * _INCH_PER_LETTER <= (each.end - each.start) * width
        for two, each in zip(words, stretches, strict=True)
    )
    for two, each in zip(words, stretches, strict=True):
        axes.annotate(
            "\n".join(two) if fits else " ".join(two),
            ((each.start + each.end) / 2, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(0 if fits else -2, 3),
            textcoords="offset points",
            ha="center" if fits else "left",
            va="bottom",
            rotation=0 if fits else 35,
            rotation_mode="anchor",
            fontsize=7,
            color="#444444",
        )
