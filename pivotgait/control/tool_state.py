"""A moving tool at one time."""

from __future__ import annotations

from typing import NamedTuple

from pivotgait.frozen import Array


class ToolState(NamedTuple):
    """The planned tool at one time, in world axes.

    Attributes:
        position: (3,) centre of mass [m].
        rotation: (3, 3) world <- tool.
        linear_velocity: (3,) of the centre of mass [m/s].
        angular_velocity: (3,) [rad/s].
        linear_acceleration: (3,) [m/s^2].
        angular_acceleration: (3,) [rad/s^2].
    """

    position: Array
    rotation: Array
    linear_velocity: Array
    angular_velocity: Array
    linear_acceleration: Array
    angular_acceleration: Array
