"""What a controller is told each cycle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pivotgait.frozen import Array


class Measurement(NamedTuple):
    """Readings at one time, errors of the sensors included.

    Attributes:
        time: since the plan's start [s].
        q: (n,) joint positions [rad] or [m].
        v: (n,) joint velocities [rad/s] or [m/s].
        force: by finger, (3,) force on the tool, world axes [N]; a finger left out reads zero.
        tool_position: (3,) centre of mass, world [m].
        tool_rotation: (3, 3) world <- tool.
        tool_linear_velocity: (3,) of the centre of mass, world [m/s].
        tool_angular_velocity: (3,) world [rad/s].
    """

    time: float
    q: Array
    v: Array
    force: Mapping[str, Array]
    tool_position: Array
    tool_rotation: Array
    tool_linear_velocity: Array
    tool_angular_velocity: Array
