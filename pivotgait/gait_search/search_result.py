"""What a search is asked for besides its goal, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from pivotgait.exceptions import InputError
from pivotgait.gait_search.candidates import CandidateOptions
from pivotgait.gait_search.cost import CostWeights
from pivotgait.gait_search.deaths import Deaths
from pivotgait.gait_search.full_plan import FoundGait

Ended = Literal["found", "exhausted", "time", "plans", "impossible"]
"""Impossible: forces forbid every order of fingers, whatever the hand can do."""


@dataclass(frozen=True)
class SearchOptions:
    """How to search.

    Attributes:
        weights: of the cost.
        candidates: how densely the handle is covered.
        pitches_deg: of lifts, besides the one of the scene's gaits [deg].
        inflation: of the estimate of the rest; above 1 the search is greedier.
        visits: times a grasp may be left on different paths: postures depend on the path.
        starts: random starts of the postures of each branch.
        plan_starts: starts of the postures of a whole plan.
        plans: most sequences that are planned fully.
        sequences: certified ones to find, of which the cheapest as measured is taken.
        time_limit_s: no branch is looked at after this time [s].
        hand: whether the scene's robot is asked; else the tool and its forces alone.
    """

    weights: CostWeights = field(default_factory=CostWeights)
    candidates: CandidateOptions = field(default_factory=CandidateOptions)
    pitches_deg: tuple[float, ...] = (10.0, 40.0)
    inflation: float = 2.0
    visits: int = 3
    starts: int = 5
    plan_starts: int = 8
    plans: int = 20
    sequences: int = 1
    time_limit_s: float = 60.0
    hand: bool = True

    def __post_init__(self) -> None:
        for name in ("inflation", "visits", "starts", "plan_starts", "plans", "sequences"):
            if not 1 <= getattr(self, name) < np.inf:
                raise InputError(f"is {getattr(self, name)}", where=name, mend="give 1 or more")
        if not self.time_limit_s > 0.0:
            mend = "give a time above 0, in seconds"
            raise InputError(f"is {self.time_limit_s}", where="time_limit_s", mend=mend)


@dataclass(frozen=True)
class News:
    """How far a search has come.

    Attributes:
        expanded: branches whose moves were looked at.
        waiting: branches.
        postures: branches whose postures were sought.
        plans: sequences planned fully.
        dead: branches and moves that died.
    """

    expanded: int
    waiting: int
    postures: int
    plans: int
    dead: int


@dataclass(frozen=True, eq=False)
class SearchResult:
    """What came of a search; nothing found is a result too.

    Attributes:
        goal: as the user named it.
        found: the cheapest certified sequence, None if there is none.
        others: further certified ones.
        ended: by what.
        news: how far it came.
        deaths: why branches died.
        elapsed_s: time spent [s].
    """

    goal: str
    found: FoundGait | None
    others: tuple[FoundGait, ...]
    ended: Ended
    news: News
    deaths: Deaths
    elapsed_s: float
