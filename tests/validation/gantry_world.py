"""The smallest world: a ball on three slides and a tool of one box or ball."""

from __future__ import annotations

import numpy as np

from pivotgait.plans import PlannedFinger
from pivotgait.validation import World

TIP_RADIUS = 0.01
SLIDE_MASS = 0.5
"""Of each of the three slides [kg]; the ball hangs on the last."""
HALF_BOX = 0.05
BOX_HEIGHT = 0.04
AXES = {"sx": "1 0 0", "sy": "0 1 0", "sz": "0 0 1"}


def _inertial(mass: float, inertia: str) -> str:
    return (
        f'<inertial><origin xyz="0 0 0"/><mass value="{mass!r}"/>\n<inertia {inertia}/></inertial>'
    )


def _round(value: float) -> str:
    return f'ixx="{value!r}" iyy="{value!r}" izz="{value!r}" ixy="0" ixz="0" iyz="0"'


def gantry() -> str:
    """URDF of the slides x, y, z, written in an order that Pinocchio does not keep."""
    lines = ['<?xml version="1.0"?>', '<robot name="gantry" version="1.1">', '<link name="root">']
    lines += [_inertial(1.0, _round(1e-2)), "</link>"]
    parent = "root"
    for name, axis in AXES.items():
        child = "ball" if name == "sz" else f"after_{name}"
        lines += [f'<link name="{child}">', _inertial(SLIDE_MASS, _round(1e-3))]
        if child == "ball":
            lines += ['<collision name="ball"><geometry>', f'<sphere radius="{TIP_RADIUS}"/>']
            lines += ["</geometry></collision>"]
        lines += ["</link>", f'<joint name="{name}" type="prismatic">']
        lines += [f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>']
        lines += ['<limit lower="-10" upper="10" effort="1000" velocity="100"/></joint>']
        parent = child
    return "\n".join([*lines, "</robot>"]) + "\n"


def box_tool(mass: float, products: float = 0.0) -> str:
    """URDF of a flat box about its centre of mass; its tip sphere is hidden inside."""
    inertia = f'ixx="2e-3" iyy="3e-3" izz="4e-3" ixy="{products!r}" ixz="{products!r}" iyz="0"'
    side = 2 * HALF_BOX
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<robot name="box" version="1.1">',
            '<link name="box">',
            _inertial(mass, inertia),
            '<collision name="body"><geometry>',
            f'<box size="{side} {side} {BOX_HEIGHT}"/></geometry></collision>',
            '<collision name="tip"><geometry><sphere radius="0.001"/></geometry></collision>',
            "</link></robot>\n",
        ]
    )


def ball_tool(mass: float, radius: float) -> str:
    """URDF of a ball that is nothing but a tip."""
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            '<robot name="marble" version="1.1">',
            '<link name="marble">',
            _inertial(mass, _round(0.4 * mass * radius**2)),
            f'<collision name="tip"><geometry><sphere radius="{radius}"/></geometry></collision>',
            "</link></robot>\n",
        ]
    )


def gantry_world(
    tool_urdf: str,
    *,
    tip_radius: float = 0.001,
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    finger_friction: float = 0.8,
    table_friction: float = 0.4,
    joint_friction: float = 0.0,
) -> World:
    """Slides and a tool above a table at z = 0."""
    return World(
        robot_urdf=gantry(),
        joint_names=("sx", "sy", "sz"),
        fingers={"ball": PlannedFinger("ball", TIP_RADIUS)},
        never_touch=(),
        tool_urdf=tool_urdf,
        pivot_in_tool=np.zeros(3),
        tip_radius=tip_radius,
        finger_friction={"ball": finger_friction},
        table_friction=table_friction,
        table_height=0.0,
        gravity=np.array(gravity),
        joint_friction=np.full(3, joint_friction),
    )
