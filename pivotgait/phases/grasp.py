"""What a phase starts from and hands on: the tool at rest, its fingers, their forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import PivotingTool
from pivotgait.models import HandleContact, Scene
from pivotgait.plans import PIVOT, ContactTrack, ToolMotion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Setting:
    """What stays the same over a whole gait.

    Attributes:
        scene: tool, table, limits and options.
        body: the tool as a body that turns about its pivot.
    """

    scene: Scene
    body: PivotingTool

    @classmethod
    def of(cls, scene: Scene) -> Setting:
        """The setting of a scene."""
        tool = scene.tool
        body = PivotingTool(
            mass=tool.mass,
            inertia=tool.inertia,
            pivot_in_tool=tool.pivot_in_tool,
            pivot=scene.pivot,
            gravity=scene.gravity,
        )
        return cls(scene, body)

    def usable_friction(self, fingers: Sequence[HandleContact]) -> Array:
        """(1 + m,) coefficients of pivot and fingers that a plan may use: without the reserve."""
        given = [self.scene.table.friction, *(finger.friction for finger in fingers)]
        return (1.0 - self.scene.allocation.friction_reserve) * np.array(given)

    def pivot_track(self, force: Array) -> ContactTrack:
        """The table contact with its forces (N, 3) in the world frame [N]."""
        scene = self.scene
        return ContactTrack(
            name=PIVOT,
            point=self.body.pivot,
            normal=np.array([0.0, 0.0, 1.0]),
            force=force,
            friction=scene.table.friction,
            normal_min=scene.table.normal_min,
            normal_max=scene.table.normal_max,
        )


def finger_track(contact: HandleContact, force: Array, *, changing: bool = False) -> ContactTrack:
    """A finger contact with its forces (N, 3) in the world frame [N].

    Args:
        contact: where the finger touches.
        force: (N, 3) on the tool, world frame [N].
        changing: whether the finger comes or goes, which frees its lower bound to 0 (else
            eq. 6 would contradict eqs 7 and 8 where the force vanishes).
    """
    return ContactTrack(
        name=contact.finger,
        point=contact.point,
        normal=contact.normal,
        force=force,
        friction=contact.friction,
        normal_min=0.0 if changing else contact.normal_min,
        normal_max=contact.normal_max,
        torsion=contact.torsion,
    )


@dataclass(frozen=True, eq=False)
class Grasp:
    """The tool at rest on its pivot.

    Attributes:
        rotation: tool orientation, world <- tool.
        fingers: finger name -> its contact, in the order the fingers came.
        forces: contact name (``pivot`` and fingers) -> (3,) force on the tool, world [N];
            empty while the tool still lies on the table.
    """

    rotation: Rotation
    fingers: Mapping[str, HandleContact]
    forces: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def after(
        cls,
        motion: ToolMotion,
        fingers: Mapping[str, HandleContact],
        contacts: Mapping[str, ContactTrack],
    ) -> Grasp:
        """The grasp in which a phase with this motion and these contacts leaves the tool."""
        held = {name: contacts[name].force[-1] for name in (PIVOT, *fingers)}
        return cls(motion.rotation[-1], MappingProxyType(dict(fingers)), MappingProxyType(held))
