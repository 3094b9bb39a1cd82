"""The study file as typed fields: what a sweep varies and what it computes."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from pivotgait.models.config import Config, Name, Positive

SCHEMA = "pivotgait-study/1"
KINDS = ("values", "names", "linspace", "range", "uniform", "loguniform", "normal")
"""Fields of an axis; each gives exactly one of them."""
DRAWN = ("uniform", "loguniform", "normal")
"""Those that are distributions."""

Compute = Literal["static", "removal", "plan", "trials"]
TIME_LIMIT_S: dict[Compute, float] = {"static": 20.0, "removal": 60.0, "plan": 300.0, "trials": 600}
"""Time after which a cell is given up, unless the study says otherwise."""
MAX_VALUES = 1_000_000


class Linspace(Config):
    """``count`` values from ``from`` to ``to``, both included, at equal distances."""

    from_: Annotated[FiniteFloat, Field(alias="from")]
    to: FiniteFloat
    count: Annotated[int, Field(ge=2, le=MAX_VALUES)]


class Range(Config):
    """``from``, ``from + step``, ... up to ``to``, included where a step meets it."""

    from_: Annotated[FiniteFloat, Field(alias="from")]
    to: FiniteFloat
    step: Positive


class Between(Config):
    """A distribution's bounds."""

    from_: Annotated[FiniteFloat, Field(alias="from")]
    to: FiniteFloat


class Normal(Config):
    """A normal distribution."""

    mean: FiniteFloat
    sd: Positive
    """Its standard deviation."""


class AxisConfig(Config):
    """The values of one parameter: exactly one of these."""

    values: (
        Annotated[tuple[FiniteFloat, ...], Field(min_length=1, max_length=MAX_VALUES)] | None
    ) = None
    """Numbers, one by one."""
    names: Annotated[tuple[str, ...], Field(min_length=1, max_length=MAX_VALUES)] | None = None
    """Names, for a field that holds one: a contact, an objective."""
    linspace: Linspace | None = None
    range: Range | None = None
    uniform: Between | None = None
    loguniform: Between | None = None
    normal: Normal | None = None

    @property
    def given(self) -> tuple[str, ...]:
        """Which of the fields the file gives."""
        return tuple(kind for kind in KINDS if getattr(self, kind) is not None)


class StaticConfig(Config):
    """Which grasp ``compute: static`` judges: contacts that hold the tool after its lift."""

    contacts: Annotated[tuple[Name, ...], Field(min_length=2)] | None = None
    """Names of the contacts; else those of the gait's lift."""


class TrialsConfig(Config):
    """What ``compute: trials`` does with the plan of each cell."""

    count: Annotated[int, Field(ge=1, le=1000)] = 1
    """Trials of each plan."""
    simulator: str = "pybullet"
    controller: str = "hybrid"
    perturbed: bool = True


class StudyConfig(Config):
    """A whole study file."""

    schema_: Annotated[Literal["pivotgait-study/1"], Field(alias="schema")]
    name: Name
    description: Annotated[str, Field(max_length=2000)] = ""
    scene: Annotated[str, Field(min_length=1, max_length=1000)]
    """A built-in scene's name, or a scene file relative to the study's."""
    gait: Name | None = None
    """Which of the scene's gaits; the first without it."""
    compute: Compute
    static: StaticConfig | None = None
    trials: TrialsConfig | None = None
    set: Annotated[dict[str, FiniteFloat], Field(default_factory=dict)]
    """Parameters that have one value in every cell."""
    axes: Annotated[dict[str, AxisConfig], Field(min_length=1, max_length=20)]
    """Parameter -> its values; the last axis varies fastest."""
    draws: Annotated[int, Field(ge=1, le=100_000_000)] | None = None
    """How often the distributions are drawn at each place of the grid."""
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0
    """Of the draws, of the planner's searches and of the first trial."""
    time_limit_s: Annotated[FiniteFloat, Field(gt=0, le=86_400)] | None = None
    """After which a cell is given up."""

    @property
    def limit_s(self) -> float:
        """After which a cell is given up [s]."""
        return self.time_limit_s or float(TIME_LIMIT_S[self.compute])
