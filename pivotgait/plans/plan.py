"""Frozen records of a gait plan: tool motion, contacts, phases."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array, FrozenArrays

PhaseKind = Literal["lift", "removal", "relocation", "addition", "transfer"]
PHASE_KINDS: tuple[str, ...] = ("lift", "removal", "relocation", "addition", "transfer")
PIVOT = "pivot"
"""Name of the table contact in every phase."""


@dataclass(frozen=True, eq=False)
class ToolMotion(FrozenArrays):
    """Motion of the tool at N samples, all in the world frame.

    Attributes:
        position: (N, 3) centre of mass o [m].
        orientation: (N, 4) unit quaternion xyzw of the tool frame, world <- tool.
        linear_velocity: (N, 3) of the centre of mass [m/s].
        angular_velocity: (N, 3) [rad/s].
        linear_acceleration: (N, 3) of the centre of mass [m/s^2].
        angular_acceleration: (N, 3) [rad/s^2].
    """

    position: Array
    orientation: Array
    linear_velocity: Array
    angular_velocity: Array
    linear_acceleration: Array
    angular_acceleration: Array

    @property
    def rotation(self) -> Rotation:
        """The N orientations, world <- tool."""
        return Rotation.from_quat(self.orientation)


@dataclass(frozen=True, eq=False)
class RobotMotion(FrozenArrays):
    """Motion of the arm-hand at N samples, joints in the order of the planned robot.

    Attributes:
        q: (N, n) joint positions [rad] or [m].
        v: (N, n) [rad/s] or [m/s].
        a: (N, n) [rad/s^2] or [m/s^2].
        tau: (N, n) joint torques or forces [N m] or [N] (Xue et al., eq. 17).
    """

    q: Array
    v: Array
    a: Array
    tau: Array


@dataclass(frozen=True, eq=False)
class ContactTrack(FrozenArrays):
    """One contact over a phase.

    Attributes:
        name: the finger's name, or ``"pivot"``.
        point: (3,) contact point [m]: tool frame for a finger, world frame for the pivot.
        normal: (3,) unit inward normal of the touched surface, same frame as ``point``
            (for the pivot: the table's upward normal).
        force: (N, 3) force on the tool [N], world frame.
        friction: Coulomb coefficient.
        normal_min: lower bound of the normal force [N] (0 for a finger that comes or goes).
        normal_max: upper bound of the normal force [N].
        torsion: coefficient of torsional friction e of a soft fingertip [m], which bears moments
            about the normal up to e f_n (less where it is pushed sideways, too); 0 for a point.
        moment: (N,) about the inward normal on the tool [N m], None for none.
    """

    name: str
    point: Array
    normal: Array
    force: Array
    friction: float
    normal_min: float
    normal_max: float
    torsion: float = 0.0
    moment: Array | None = None

    @property
    def is_pivot(self) -> bool:
        """Whether this is the table contact."""
        return self.name == PIVOT

    def world_normal(self, motion: ToolMotion) -> Array:
        """(N, 3) inward normal in the world frame along ``motion``."""
        if self.is_pivot:
            return np.broadcast_to(self.normal, self.force.shape)
        # SciPy's Rotation.apply refuses read-only arrays.
        return np.asarray(motion.rotation.as_matrix() @ self.normal)

    def world_point(self, motion: ToolMotion) -> Array:
        """(N, 3) contact point in the world frame [m] along ``motion``."""
        if self.is_pivot:
            return np.broadcast_to(self.point, self.force.shape)
        return np.asarray(motion.position + motion.rotation.as_matrix() @ self.point)


@dataclass(frozen=True, eq=False)
class Phase(FrozenArrays):
    """One phase of a plan: N = K + 1 samples.

    Attributes:
        name: unique within the plan, ``NN_kind`` with NN its place in the order.
        kind: one of :data:`PHASE_KINDS`.
        finger: the finger that moves or changes, empty for a lift.
        time: (N,) seconds from the phase's start.
        tool: motion of the tool.
        contacts: by name, the pivot and each finger that touches at any time of the phase.
        robot: motion of the arm-hand, None in a plan without one.
        record: facts about the making (solver, iterations, cost, timings); not stored in files.
    """

    name: str
    kind: PhaseKind
    finger: str
    time: Array
    tool: ToolMotion
    contacts: Mapping[str, ContactTrack]
    robot: RobotMotion | None = None
    record: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "contacts", MappingProxyType(dict(self.contacts)))

    @property
    def duration_s(self) -> float:
        """Length of the phase [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def reorientation_deg(self) -> float:
        """Angle between the first and the last orientation [deg]."""
        turn = self.tool.rotation[0].inv() * self.tool.rotation[-1]
        return float(np.degrees(turn.magnitude()))


@dataclass(frozen=True, eq=False)
class PlannedTool(FrozenArrays):
    """What a plan must know of its tool.

    Attributes:
        name: the tool's name.
        mass: [kg].
        inertia: (3, 3) at the centre of mass in the tool frame [kg m^2].
        pivot_in_tool: (3,) pivot in the tool frame, whose origin is the centre of mass [m].
        urdf: text of the tool's URDF (root link axes are the tool frame's axes).
        centre_of_mass_in_root: (3,) origin of the tool frame in the URDF's root link [m].
    """

    name: str
    mass: float
    inertia: Array
    pivot_in_tool: Array
    urdf: str
    centre_of_mass_in_root: Array


@dataclass(frozen=True)
class PlannedFinger:
    """A fingertip: a sphere about its frame's origin.

    Attributes:
        tip_frame: name of the frame (a link of the robot's URDF).
        tip_radius: [m].
    """

    tip_frame: str
    tip_radius: float


@dataclass(frozen=True, eq=False)
class PlannedRobot:
    """What a plan must know of its arm-hand.

    Attributes:
        urdf: the whole text; its root is the world frame.
        joint_names: in the order of the columns of :class:`RobotMotion`.
        fingers: by the name of their contacts.
        couplings: pairs of joint names (a, b) with the rule q_a <= q_b.
        never_touch: pairs of link names whose distance does not count.
    """

    urdf: str
    joint_names: tuple[str, ...]
    fingers: Mapping[str, PlannedFinger]
    couplings: tuple[tuple[str, str], ...] = ()
    never_touch: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, eq=False)
class GaitPlan(FrozenArrays):
    """A whole gait: what ``plan.h5`` holds.

    Attributes:
        scene: the scene's YAML text as used.
        seed: of the planners' random generator.
        versions: package name -> version that made the plan.
        gravity: (3,) world [m/s^2].
        table_height: z of the table plane [m].
        tool: the tool.
        phases: in order; consecutive phases join.
        robot: the arm-hand, None for a plan of the tool and its forces only.
        certificate: what ``pivotgait certify`` says of the plan, or None before that.
    """

    scene: str
    seed: int
    versions: Mapping[str, str]
    gravity: Array
    table_height: float
    tool: PlannedTool
    phases: tuple[Phase, ...]
    robot: PlannedRobot | None = None
    certificate: Mapping[str, Any] | None = None
