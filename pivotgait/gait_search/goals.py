"""What a search is after: which contacts hold the tool in the end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.states import GraspState

PALM_MAX_M, OPPOSING_DEG = 0.06, 120.0
"""Of a power grasp that says no more: palm to the handle's axis [m], angle of normals [deg]."""


@dataclass(frozen=True)
class Missing:
    """What must happen at least from a state to the goal.

    Attributes:
        additions: of fingers.
        removals: of fingers.
    """

    additions: int
    removals: int


class Goal(Protocol):
    """A wanted grasp."""

    @property
    def text(self) -> str:
        """As the user named it."""
        ...

    @property
    def palm_max_m(self) -> float:
        """Largest distance of the palm from the handle's axis [m]; infinite if any."""
        ...

    @property
    def contacts(self) -> Mapping[str, Candidate]:
        """Contacts that it names, by their names; the search may use them everywhere."""
        ...

    @property
    def lifted_off(self) -> bool:
        """Whether the tool is to be taken off the table in the end."""
        ...

    def reached(self, held: Mapping[str, Candidate]) -> bool:
        """Whether fingers hold the tool as wanted."""
        ...

    def missing(self, held: Mapping[str, Candidate]) -> Missing:
        """What must happen at least until they do; never too much."""
        ...


@dataclass(frozen=True, eq=False)
class NamedGrasp:
    """Exactly these contacts hold the tool.

    Attributes:
        text: as the user named it.
        contacts: by name, one for each finger.
        palm_max_m: infinite: the palm may be anywhere.
        lifted_off: no; it holds the tool on its pivot.
    """

    text: str
    contacts: Mapping[str, Candidate]
    palm_max_m: float = np.inf
    lifted_off: bool = False

    def reached(self, held: Mapping[str, Candidate]) -> bool:
        """Whether the contacts named hold the tool and no others."""
        return {each.name for each in held.values()} == set(self.contacts)

    def missing(self, held: Mapping[str, Candidate]) -> Missing:
        """Contacts not held yet, and others that are."""
        names = {each.name for each in held.values()}
        return Missing(len(set(self.contacts) - names), len(names - set(self.contacts)))


@dataclass(frozen=True, eq=False)
class PowerGrasp:
    """A finger opposes at least two others around the handle, and the palm is near it.

    Attributes:
        text: as the user named it.
        palm_max_m: largest distance of the palm's shapes from the handle's axis [m].
        by: finger that opposes the others, such as the thumb; None for any.
        lifted_off: no; it holds the tool on its pivot.
        opposing_min_deg: least angle between the normals of the opposing finger and each other.
    """

    text: str = "power-grasp"
    palm_max_m: float = PALM_MAX_M
    by: str | None = None
    lifted_off: bool = False
    opposing_min_deg: float = OPPOSING_DEG

    @property
    def contacts(self) -> Mapping[str, Candidate]:
        """None: any do."""
        return {}

    def reached(self, held: Mapping[str, Candidate]) -> bool:
        """Whether one finger opposes all others, two or more."""
        others = len(held) - 1
        return others >= 2 and any(
            self._opposed(held, name) == others for name in self._opposing(held)
        )

    def missing(self, held: Mapping[str, Candidate]) -> Missing:
        """The fewest changes: a finger that comes may oppose all that hold already."""
        if self.reached(held):
            return Missing(0, 0)
        if len(held) > 3:
            return Missing(0, 0)  # one removal or one addition may do: neither is a must
        return Missing(max(3 - len(held), 1), 0)

    def _opposing(self, held: Mapping[str, Candidate]) -> list[str]:
        return [name for name in held if self.by in (None, name)]

    def _opposed(self, held: Mapping[str, Candidate], name: str) -> int:
        """Number of others whose normals oppose that of a finger."""
        least, one = np.cos(np.radians(self.opposing_min_deg)), held[name].contact.normal
        others = [each.contact.normal for finger, each in held.items() if finger != name]
        return sum(bool(one @ normal <= least + 1e-12) for normal in others)


@dataclass(frozen=True, eq=False)
class LiftedOff:
    """These fingers carry the tool off the table, at these contacts or wherever they hold it.

    Attributes:
        text: as the user named it.
        fingers: two or more.
        contacts: by name, one for each finger; empty if any do.
        palm_max_m: infinite: the palm may be anywhere.
        lifted_off: yes.
    """

    text: str
    fingers: frozenset[str]
    contacts: Mapping[str, Candidate]
    palm_max_m: float = np.inf
    lifted_off: bool = True

    def reached(self, held: Mapping[str, Candidate]) -> bool:
        """Whether these fingers hold the tool as wanted and no others."""
        return set(held) == self.fingers and self._good(held) == len(held)

    def missing(self, held: Mapping[str, Candidate]) -> Missing:
        """Fingers that do not hold as wanted yet, and all that hold otherwise."""
        good = self._good(held)
        return Missing(len(self.fingers) - good, len(held) - good)

    def _good(self, held: Mapping[str, Candidate]) -> int:
        """Number of fingers that hold as wanted."""
        return sum(
            finger in self.fingers and (not self.contacts or each.name in self.contacts)
            for finger, each in held.items()
        )


def estimate_moves(goal: Goal, state: GraspState, lifted_by: int) -> tuple[int, Missing]:
    """Lifts, additions and removals that the goal needs from a state, at least.

    Args:
        goal: wanted.
        state: here.
        lifted_by: most fingers that a lift brings at once.
    """
    missing = goal.missing(state.held)
    if state.held:
        return 0, missing
    return 1, Missing(max(missing.additions - lifted_by, 0), missing.removals)
