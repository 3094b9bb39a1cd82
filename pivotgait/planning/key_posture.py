"""Moments of a gait at which the hand's posture is sought: a tool pose and who touches it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import HandleContact, Robot


@dataclass(frozen=True, eq=False)
class KeyPose(FrozenArrays):
    """The tool at one moment and the contacts the hand must reach on it.

    Attributes:
        name: of the moment, for messages.
        rotation: (3, 3) orientation of the tool, world <- tool.
        position: (3,) of its centre of mass, world [m].
        contacts: finger -> its contact.
    """

    name: str
    rotation: Array
    position: Array
    contacts: Mapping[str, HandleContact]

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "contacts", MappingProxyType(dict(self.contacts)))
        if not (np.isfinite(self.rotation).all() and np.isfinite(self.position).all()):
            raise InputError("the tool's pose is not finite", where=self.name, mend="look for NaN")


def held_on(keys: Sequence[KeyPose]) -> tuple[tuple[str, int, int], ...]:
    """(finger, k, k + 1) for every contact that lasts from a key pose to the next."""
    return tuple(
        (finger, k, k + 1)
        for k in range(len(keys) - 1)
        for finger, contact in keys[k].contacts.items()
        if finger in keys[k + 1].contacts and keys[k + 1].contacts[finger].name == contact.name
    )


def check_fingers(keys: Sequence[KeyPose], robot: Robot) -> None:
    """Raise UnknownNameError for a contact whose finger the robot does not have."""
    for key in keys:
        for finger in key.contacts:
            if finger not in robot.fingers:
                raise UnknownNameError("finger", finger, robot.fingers, where=key.name)
