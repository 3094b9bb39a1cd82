"""Goals from the words of the command line."""

from __future__ import annotations

import re
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.gait_search.candidates import (
    Candidate,
    candidate_at,
    fingers_of,
    own_candidates,
)
from pivotgait.gait_search.goals import PALM_MAX_M, Goal, LiftedOff, NamedGrasp, PowerGrasp
from pivotgait.models import Scene

_PLACE = re.compile(r"^(?P<finger>[^@]+)@(?P<along>[^/@]+)/(?P<around>[^/@]+)$")
_LIFTED = re.compile(r"^lifted off by (?P<names>.+)$")
_POWER = re.compile(r"^power[- ]grasp(?: by (?P<by>\S+))?(?: within (?P<palm>\S+) m)?$")
FEWEST = 2
"""Fingers that hold a tool on its pivot."""


def read_goal(text: str, scene: Scene, *, where: str = "--goal") -> Goal:
    """The goal that a text names.

    * ``thumb_spine, middle_flat, index_edge_near``: exactly these contacts of the scene;
      ``index@0.03/180`` is a place of one's own, 0.03 m along the handle and 180 deg around it.
    * ``power-grasp``, ``power-grasp by thumb within 0.05 m``: a finger, or this one, opposes two
      others, and the palm is that near to the handle's axis.
    * ``lifted off by thumb_top and middle_below``, ``lifted off by thumb and middle``: these
      contacts, or these fingers anywhere, take the tool off the table alone.

    Raises:
        InputError: for a text that is none of these or cannot be held.
        UnknownNameError: for a contact or a finger that the scene does not have.
        SceneError: for a place off the handle.
    """
    words = " ".join(text.split())
    if not words:
        raise InputError("is empty", where=where, mend=_mend(scene))
    if lifted := _LIFTED.match(words):
        return _lifted(words, lifted["names"], scene, where)
    if power := _POWER.match(words):
        return _power(words, power["by"], power["palm"], scene, where)
    contacts = [_contact(part.strip(), scene, where) for part in words.split(",")]
    return NamedGrasp(words, _one_each(contacts, where))


def read_contacts(text: str, scene: Scene, *, where: str) -> tuple[Candidate, ...]:
    """Contacts of two fingers or more, written as in a goal.

    Raises:
        InputError, UnknownNameError, SceneError: as :func:`read_goal`.
    """
    contacts = [_contact(part.strip(), scene, where) for part in text.split(",")]
    return tuple(_one_each(contacts, where).values())


def _one_each(contacts: list[Candidate], where: str) -> MappingProxyType[str, Candidate]:
    fingers = [each.finger for each in contacts]
    for finger in fingers:
        if fingers.count(finger) > 1:
            mend = "name one contact for each finger"
            raise InputError(f"finger {finger!r} cannot be at two places", where=where, mend=mend)
    if len(contacts) < FEWEST:
        mend = "name two contacts or more: one finger cannot hold the tool on its pivot"
        raise InputError(f"names {len(contacts)} contact", where=where, mend=mend)
    return MappingProxyType({each.name: each for each in contacts})


def _contact(word: str, scene: Scene, where: str) -> Candidate:
    own = dict(own_candidates(scene))
    if word in own:
        return own[word]
    place = _PLACE.match(word)
    if place is None:
        raise UnknownNameError("contact", word, scene.contacts, where=where)
    finger = place["finger"].strip()
    if finger not in fingers_of(scene):
        raise UnknownNameError("finger", finger, fingers_of(scene), where=where)
    along, around = (_number(place[each], word, where) for each in ("along", "around"))
    return candidate_at(scene, finger, (along, around), where=f"{where}: {word}")


def _number(text: str, word: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        mend = "write FINGER@ALONG_M/AROUND_DEG, for example index@0.03/180"
        raise InputError(f"cannot read the place {word!r}", where=where, mend=mend)
    return value


def _power(words: str, by: str | None, palm: str | None, scene: Scene, where: str) -> PowerGrasp:
    if by is not None and by not in fingers_of(scene):
        raise UnknownNameError("finger", by, fingers_of(scene), where=where)
    if len(fingers_of(scene)) < 3:
        mend = "give the scene a third finger"
        raise InputError("a power grasp needs three fingers", where=where, mend=mend)
    if palm is None:
        return PowerGrasp(words, PALM_MAX_M, by)
    distance = _number(palm, words, where)
    if distance <= 0.0:
        mend = "give a distance above 0, in metres"
        raise InputError(f"the palm cannot be within {distance:g} m", where=where, mend=mend)
    return PowerGrasp(words, distance, by)


def _lifted(words: str, names: str, scene: Scene, where: str) -> Goal:
    parts = [each.strip() for each in re.split(r",| and ", names)]
    if any(each in fingers_of(scene) for each in parts):
        for finger in parts:
            if finger not in fingers_of(scene):
                raise UnknownNameError("finger", finger, fingers_of(scene), where=where)
        if len(set(parts)) < FEWEST:
            mend = "write 'lifted off by thumb and middle'"
            raise InputError("a tool is lifted off by two fingers or more", where=where, mend=mend)
        return LiftedOff(words, frozenset(parts), MappingProxyType({}))
    contacts = _one_each([_contact(part, scene, where) for part in parts], where)
    return LiftedOff(words, frozenset(each.finger for each in contacts.values()), contacts)


def _mend(scene: Scene) -> str:
    return f"name contacts, of {', '.join(scene.contacts)}, or 'power-grasp'"
