"""Room for a fingertip behind the contact it leaves and before the one it comes to.

A relocation begins and ends straight along a contact's normal. Whether the hand lets a finger do so
depends on its posture: for a whole sequence, postures are fitted to such moments, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.notes import Branches, notes_of
from pivotgait.planning.key_posture import KeyPose

BESIDE_M = 0.004
"""Room before a contact [m]: half of the straight way of a relocation."""


@dataclass(frozen=True)
class Moment:
    """A key pose of a sequence with room beside contacts.

    Attributes:
        key: the pose.
        like: place among the sequence's own key poses of the one whose posture is near.
        own: whether it is that one.
    """

    key: KeyPose
    like: int
    own: bool


def with_room(path: Sequence[Branches]) -> Iterator[Moment]:
    """The key poses of a sequence, and moments beside the contacts that a finger leaves or nears.

    Args:
        path: to a branch with postures, each branch of it with postures of its own.
    """
    done = 0
    for branch in path:
        prefix, before, move = notes_of(branch).prefix, branch.parent, branch.move
        assert prefix is not None
        assert before is not None
        assert move is not None
        if move.kind == "addition":
            (coming,), here = move.contacts, prefix.keys[done]
            if (left := before.state.left.get(coming.finger)) is not None:
                yield Moment(_beside(here, left), done - 1, own=False)
            yield Moment(_beside(here, coming), done, own=False)
        for place in range(done, prefix.done):
            yield Moment(prefix.keys[place], place, own=True)
        done = prefix.done


def _beside(key: KeyPose, at: Candidate) -> KeyPose:
    """The moment of a key pose with a finger a little out along the normal of a contact."""
    contacts = {**key.contacts, at.finger: at.contact.standing_off(BESIDE_M)}
    return replace(key, name=f"beside {at.name}", contacts=contacts)
