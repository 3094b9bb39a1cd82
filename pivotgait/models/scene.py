"""The scene: tool, table, contacts and gaits, loaded and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.rest import attitude
from pivotgait.models.robot import Robot
from pivotgait.models.scene_config import (
    AllocationConfig,
    LiftTarget,
    PhaseConfig,
    SceneConfig,
)
from pivotgait.models.tool import Tool


@dataclass(frozen=True, eq=False)
class Table(FrozenArrays):
    """A horizontal table in the world frame.

    Attributes:
        height: z of its plane [m].
        centre: (2,) x and y of its middle [m].
        half_size: (2,) half its sides along x and y [m].
        friction: Coulomb coefficient between tip and table.
        normal_min: lower bound of the tip's normal force [N].
        normal_max: upper bound of the tip's normal force [N].
    """

    height: float
    centre: Array
    half_size: Array
    friction: float
    normal_min: float
    normal_max: float


@dataclass(frozen=True, eq=False)
class HandleContact(FrozenArrays):
    """A place on the handle for a finger.

    Attributes:
        name: of the contact.
        finger: that may touch it.
        point: (3,) in the tool frame [m].
        normal: (3,) unit inward normal in the tool frame.
        friction: Coulomb coefficient.
        normal_min: lower bound of the normal force [N].
        normal_max: upper bound of the normal force [N].
        torsion: coefficient of torsional friction [m], 0 for a point contact.
    """

    name: str
    finger: str
    point: Array
    normal: Array
    friction: float
    normal_min: float
    normal_max: float
    torsion: float = 0.0

    def standing_off(self, distance: float) -> HandleContact:
        """The place this far [m] out along the normal, where a fingertip is in the air."""
        place = self.point - distance * self.normal
        return replace(self, name=f"{self.name}, stood off", point=place)


@dataclass(frozen=True, eq=False)
class Scene(FrozenArrays):
    """Everything a plan starts from.

    Attributes:
        name: of the scene.
        description: one or two sentences.
        config: the file's fields.
        yaml: the file's text as used.
        tool: the tool.
        table: the table.
        robot: the arm-hand, None for a scene that plans the tool's motion and forces only.
        gravity: (3,) world [m/s^2].
        clearance: smallest distance to what must not be touched [m].
        pivot: (3,) centre of the tip sphere, world [m]; fixed while the tool pivots.
        rest_pitch: pitch at rest [rad].
        rest_orientation: (4,) unit quaternion xyzw at rest, world <- tool.
        contacts: by name.
        gaits: phases by the gait's name.
    """

    name: str
    description: str
    config: SceneConfig
    yaml: str
    tool: Tool
    table: Table
    robot: Robot | None
    gravity: Array
    clearance: float
    pivot: Array
    rest_pitch: float
    rest_orientation: Array
    contacts: Mapping[str, HandleContact]
    gaits: Mapping[str, tuple[PhaseConfig, ...]]

    @property
    def allocation(self) -> AllocationConfig:
        """How contact forces are chosen."""
        return self.config.allocation

    @property
    def rest_rotation(self) -> Rotation:
        """Orientation at rest, world <- tool."""
        return Rotation.from_quat(self.rest_orientation)

    @property
    def rest_position(self) -> Array:
        """(3,) centre of mass at rest, world [m] (Xue et al., eq. 1)."""
        return self.centre_of_mass(self.rest_rotation)

    def centre_of_mass(self, rotation: Rotation) -> Array:
        """World position of the centre of mass [m] while the tip is at the pivot (eq. 1).

        Args:
            rotation: one or N orientations, world <- tool; returns (3,) or (N, 3).
        """
        # Not Rotation.apply, which refuses read-only vectors.
        return np.asarray(self.pivot - rotation.as_matrix() @ self.tool.pivot_in_tool)

    def lift_rotation(self, target: LiftTarget) -> Rotation:
        """Orientation a lift ends in: its pitch; roll and yaw added to those of the rest."""
        rest = self.config.rest
        yaw, roll = rest.yaw_deg + target.yaw_deg, rest.roll_deg + target.roll_deg
        return attitude(*np.radians([yaw, target.pitch_deg, roll]))

    def height(self, rotation: Rotation) -> Array:
        """Height [m] of the tool's lowest point but the tip over the table; (), or (N,)."""
        return self.tool.height(rotation.as_matrix())
