"""The robot of a scene file as typed fields."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, FiniteFloat

from pivotgait.models.config import Angle, Config, Positive, Vector3

UrdfName = Annotated[str, Field(min_length=1, max_length=1000)]
LinkName = Annotated[str, Field(min_length=1, max_length=100)]
JointPositions = dict[LinkName, FiniteFloat]
"""By the joint's name [rad] or [m]."""


class BaseConfig(Config):
    """Where the robot's root link stands in the world."""

    position_m: Vector3 = (0.0, 0.0, 0.0)
    yaw_deg: Angle = 0.0


class MountConfig(Config):
    """An arm and a hand, joined at a frame of the arm.

    A name of the hand which the arm has, too, gets the prefix ``hand_``; the others stay.
    """

    arm: UrdfName
    hand: UrdfName
    frame: LinkName
    """Link of the arm that carries the hand's root link."""
    position_m: Vector3 = (0.0, 0.0, 0.0)
    """Of the hand's root in that link."""
    rpy_deg: Vector3 = (0.0, 0.0, 0.0)


class FingerConfig(Config):
    """A finger: a chain of joints with a sphere at its end."""

    tip_frame: LinkName
    tip_radius_m: Positive
    pad: Vector3
    """Direction from the tip's centre to the middle of the pad, in the tip frame, any length."""
    pad_cone_deg: Annotated[FiniteFloat, Field(gt=0, le=120)] = 60.0
    """Largest angle between ``pad`` and the direction to a contact."""
    joints: Annotated[tuple[LinkName, ...], Field(min_length=1)]


class RobotConfig(Config):
    """The arm-hand: a built-in model's name or a URDF path, or an arm and a hand to join.

    A path is relative to the scene file, or ``example-robot-data:`` and a path below the robots
    of that package. Meshes are replaced by primitives that enclose them.
    """

    urdf: UrdfName | None = None
    mount: MountConfig | None = None
    base: BaseConfig = BaseConfig()
    fixed: JointPositions = Field(default_factory=dict)
    """Joints locked at these positions [rad] or [m], such as those of an unused finger."""
    palm: LinkName
    fingers: Annotated[dict[LinkName, FingerConfig], Field(min_length=2)]
    couplings: tuple[tuple[LinkName, LinkName], ...] = ()
    """Pairs of joints of which the first never flexes more than the second."""
    home: JointPositions = Field(default_factory=dict)
    """Joint positions [rad] or [m] of a comfortable posture; the middle of the range if missing."""
    ramp_time_s: Positive = 0.2
    """Time from rest to the joints' full speed: bounds their accelerations."""
    never_touch: tuple[tuple[LinkName, LinkName], ...] = ()
    """Pairs of links that cannot meet or may overlap, besides neighbours."""
