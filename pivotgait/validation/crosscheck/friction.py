"""Coulomb's law in an engine: a block on a plane starts to slide where it should."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plans import PlannedFinger
from pivotgait.validation.simulator import SimulatorOptions, make_simulator
from pivotgait.validation.world import World

_DIRECTIONS = 8
_BISECTIONS = 5
_STEPS = 150
_SPAN = 0.32
"""Shares of Coulomb's limit from 1 - span to 1 + span are searched, to span / 2^4 = 2 %."""
_HALF_HEIGHT, _SIDE = 0.05, 0.4
_MASS = 1.0
_TIP_RADIUS = 1e-3
_GRAVITY = 9.81
_UPRIGHT = np.eye(3)


def friction_deviation(engine: str, friction: float) -> tuple[float, str]:
    """How far an engine's slip threshold is from the coefficient asked for.

    A block of 1 kg is pulled along a plane by gravity that leans over; what share of Coulomb's
    limit it withstands is found by bisection, to 2 %, in eight directions.

    Args:
        engine: name of a simulator.
        friction: coefficient of block and plane.

    Returns:
        Largest deviation of the threshold over the coefficient, and the direction [deg] it is in.

    Raises:
        InputError: the simulator is not installed.
        UnknownNameError: there is none of that name.
    """
    return max((abs(share - 1.0), where) for share, where in _thresholds(engine, friction))


def _thresholds(engine: str, friction: float) -> Iterator[tuple[float, str]]:
    for angle in np.arange(_DIRECTIONS) * 2.0 * np.pi / _DIRECTIONS:
        direction = np.array([np.cos(angle), np.sin(angle)])
        low, high = 1.0 - _SPAN, 1.0 + _SPAN
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if _slides(engine, friction, middle * direction):
                high = middle
            else:
                low = middle
        yield 0.5 * (low + high), f"{np.degrees(angle):.0f} deg"


def _slides(engine: str, friction: float, pull: Array) -> bool:
    """Whether the block slides under ``pull`` (2,), a share of Coulomb's limit."""
    leaning = np.array([*(friction * _GRAVITY * pull), -_GRAVITY])
    with make_simulator(engine, _world(friction, leaning), SimulatorOptions()) as simulator:
        simulator.reset(np.zeros(1), np.zeros(1), np.array([0.0, 0.0, _HALF_HEIGHT]), _UPRIGHT)
        for _ in range(_STEPS):
            simulator.step(np.zeros(1))
        speed = float(np.linalg.norm(simulator.state().tool_linear_velocity[:2]))
    # beyond the limit by 1 % of it, the block would gain this
    return speed > 0.01 * friction * _GRAVITY * _STEPS * simulator.step_s


def _world(friction: float, gravity: Array) -> World:
    return World(
        robot_urdf=_BYSTANDER,
        joint_names=("slide",),
        fingers={"bystander": PlannedFinger("slider", _TIP_RADIUS)},
        never_touch=(),
        tool_urdf=_block(),
        pivot_in_tool=np.zeros(3),
        tip_radius=_TIP_RADIUS,
        finger_friction={"bystander": 1.0},
        table_friction=friction,
        table_height=0.0,
        gravity=gravity,
        joint_friction=np.zeros(1),
    )


def _block() -> str:
    height = 2.0 * _HALF_HEIGHT
    level, upright = (_MASS * (a**2 + b**2) / 12.0 for a, b in ((_SIDE, height), (_SIDE, _SIDE)))
    moments = f'ixx="{level!r}" iyy="{level!r}" izz="{upright!r}" ixy="0" ixz="0" iyz="0"'
    return f"""<?xml version="1.0"?>
<robot name="block" version="1.1">
<link name="block">
<inertial><mass value="{_MASS!r}"/><inertia {moments}/></inertial>
<collision name="body"><geometry><box size="{_SIDE} {_SIDE} {height}"/></geometry></collision>
<collision name="tip"><geometry><sphere radius="{_TIP_RADIUS}"/></geometry></collision>
</link>
</robot>
"""


_INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
_BYSTANDER = f"""<?xml version="1.0"?>
<robot name="bystander" version="1.1">
<link name="stand">{_INERTIAL}</link>
<link name="slider">{_INERTIAL}
<collision name="tip"><origin xyz="0 0 50"/>
<geometry><sphere radius="{_TIP_RADIUS}"/></geometry></collision>
</link>
<joint name="slide" type="prismatic">
<parent link="stand"/><child link="slider"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="10" velocity="10"/>
</joint>
</robot>
"""
