"""An arm-hand as surfaces: light arm, dark hand, each finger in its own colour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pivotgait.frozen import Array
from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.posture import ARM, HAND, Skeleton, skeleton
from pivotgait.plotting.render import Surface
from pivotgait.plotting.shapes import shape_faces
from pivotgait.plotting.style import contact_colours, mixed

_ARM_COLOUR, _HAND_COLOUR = "#D3D6D9", "#565B60"
_PHALANX_TINT = 0.35
"""How much white is in the phalanges' colour: forces and tips in the full one stand out."""


@dataclass(frozen=True, eq=False)
class RobotSurfaces:
    """Surfaces of an arm-hand.

    Attributes:
        skeleton: where its links are.
        links: by name of the link, surfaces in the link's own frame [m].
    """

    skeleton: Skeleton
    links: Mapping[str, tuple[Surface, ...]]

    def placed(self, q: Array) -> list[Surface]:
        """All surfaces in the world at joint positions q (n,)."""
        poses = self.skeleton.poses(q[None, :])
        return [
            Surface(surface.faces @ pose[0, :3, :3].T + pose[0, :3, 3], surface.colour)
            for name, pose in poses.items()
            for surface in self.links.get(name, ())
        ]


def robot_surfaces(
    plan: GaitPlan, *, arm: bool = True, largest_face: float = 0.008
) -> RobotSurfaces | None:
    """Surfaces of a plan's arm-hand, None for a plan without one.

    Args:
        plan: a gait.
        arm: whether links above the palm are wanted too.
        largest_face: faces are no longer than this [m].

    Raises:
        UrdfError: if the robot's URDF is broken.
    """
    if plan.robot is None:
        return None
    body = skeleton(plan.robot)
    colours = part_colours(body, contact_colours(plan))
    links = {
        name: tuple(
            Surface(shape_faces(shape, largest_face), colours[name])
            for shape in link.collisions
            if shape.kind != "mesh"
        )
        for name, link in body.urdf.links.items()
        if arm or body.parts[name] != ARM
    }
    return RobotSurfaces(body, links)


def part_colours(body: Skeleton, fingers: Mapping[str, str]) -> dict[str, str]:
    """Colour of each link; a fingertip's own link is darker than the rest of its finger.

    Args:
        body: the arm-hand.
        fingers: colour by the finger's name.
    """
    colours = {ARM: _ARM_COLOUR, HAND: _HAND_COLOUR}
    colours |= {name: mixed(colour, _PHALANX_TINT) for name, colour in fingers.items()}
    found = {link: colours[part] for link, part in body.parts.items()}
    return found | {link: fingers[body.parts[link]] for link in body.tips}


def middle_of(surfaces: list[Surface]) -> Array:
    """(3,) middle of the box around surfaces [m]."""
    points = np.concatenate([surface.faces.reshape(-1, 3) for surface in surfaces])
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)
