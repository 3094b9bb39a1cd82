"""From where to look: the direction from which a hand hides the fewest of its fingertips."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plotting.render import Camera

_AZIMUTHS = np.radians(np.arange(0.0, 360.0, 15.0))
_ELEVATIONS = np.radians((20.0, 33.0, 48.0))
_HABIT = 0.05
"""How many hidden fingertips looking from the opposite of the usual direction is worth."""


class Direction(NamedTuple):
    """Where the eye is: its azimuth and elevation [rad] as seen from what it looks at."""

    azimuth: float
    elevation: float

    @property
    def camera(self) -> Camera:
        """A camera with its eye there."""
        return Camera.looking_from(self.azimuth, self.elevation)


class Sight(NamedTuple):
    """What can be seen at one moment, in the world [m].

    Attributes:
        faces: (F, 4, 3) of all bodies.
        centres: (k, 3) of spheres that one wants to see.
        radii: (k,) of them.
    """

    faces: Array
    centres: Array
    radii: Array


def usual_direction(towards_tip: Array) -> Direction:
    """Before the tip and above it: a lifted tool shows both its sides there.

    Args:
        towards_tip: (3,) from the tool's mass centre to its tip, in the world.
    """
    azimuth = np.arctan2(towards_tip[1], towards_tip[0]) + np.radians(48.0)
    return Direction(float(azimuth), float(np.radians(33.0)))


def clearest_direction(sights: Sequence[Sight], usual: Direction) -> Direction:
    """The direction from which most spheres are seen over all ``sights``; of equals the usual."""
    choices = [Direction(float(a), float(e)) for a in _AZIMUTHS for e in _ELEVATIONS]
    return max([usual, *choices], key=lambda choice: _merit(sights, choice, usual))


def _merit(sights: Sequence[Sight], choice: Direction, usual: Direction) -> float:
    eye, habit = choice.camera.axes[2], usual.camera.axes[2]
    seen = sum(visible(sight, choice.camera) for sight in sights)
    return seen / max(len(sights), 1) + _HABIT * float(eye @ habit)


def visible(sight: Sight, camera: Camera) -> int:
    """How many spheres of a sight show the point that is nearest to the eye."""
    nearest = sight.centres + 1.05 * sight.radii[:, None] * camera.axes[2]
    point = camera.project(nearest)
    middle = camera.project(sight.faces.mean(axis=1))
    reach = np.linalg.norm(sight.faces[:, 0] - sight.faces[:, 2], axis=1) / 2
    apart = np.linalg.norm(point[:, None, :2] - middle[None, :, :2], axis=2)
    covered = (apart < reach) & (middle[None, :, 2] > point[:, None, 2])
    return int(np.count_nonzero(~covered.any(axis=1)))
