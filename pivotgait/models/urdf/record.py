"""What a checked URDF says: links, joints and shapes as frozen records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.shape import Shape

JointKind = Literal["revolute", "prismatic", "fixed"]


@dataclass(frozen=True, eq=False)
class UrdfInertial(FrozenArrays):
    """Mass properties of a link.

    Attributes:
        mass: [kg], > 0.
        centre_of_mass: (3,) in the link frame [m].
        inertia: (3, 3) at the centre of mass along the axes of the link frame [kg m^2].
    """

    mass: float
    centre_of_mass: Array
    inertia: Array


@dataclass(frozen=True, eq=False)
class UrdfLink:
    """A link; its shapes are placed in the link frame.

    Attributes:
        name: unique among the links.
        inertial: None for a root or a fixed frame without mass.
        collisions: in the file's order.
        visuals: in the file's order.
    """

    name: str
    inertial: UrdfInertial | None
    collisions: tuple[Shape, ...]
    visuals: tuple[Shape, ...]


@dataclass(frozen=True, eq=False)
class UrdfJoint(FrozenArrays):
    """A joint, parent <- child at its zero.

    Attributes:
        name: unique among the joints.
        kind: revolute, prismatic or fixed.
        parent: name of the parent link.
        child: name of the child link.
        rotation: (3, 3) parent link <- joint frame.
        translation: (3,) joint's origin in the parent link's frame [m].
        axis: (3,) unit axis in the joint frame.
        lower: [rad] or [m].
        upper: [rad] or [m].
        effort: largest torque or force [N m] or [N].
        velocity: largest speed [rad/s] or [m/s].
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    rotation: Array
    translation: Array
    axis: Array
    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    velocity: float = 0.0


@dataclass(frozen=True, eq=False)
class UrdfSummary:
    """A URDF that passed every check.

    Attributes:
        name: of the robot.
        version: of the ``<robot>`` element, ``"1.0"`` where it has none.
        text: the whole text.
        root: name of the one link without a parent.
        links: by name, in the file's order.
        joints: by name, in the file's order.
    """

    name: str
    version: str
    text: str
    root: str
    links: Mapping[str, UrdfLink]
    joints: Mapping[str, UrdfJoint]

    @property
    def collisions(self) -> tuple[Shape, ...]:
        """Every collision shape, each in the frame of its own link."""
        return tuple(shape for link in self.links.values() for shape in link.collisions)

    @property
    def mass(self) -> float:
        """Sum of the links' masses [kg]."""
        return sum(link.inertial.mass for link in self.links.values() if link.inertial)
