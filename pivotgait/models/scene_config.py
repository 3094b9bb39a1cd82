"""The scene file as typed fields: what ``scene.yaml`` may say, with units in the names."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from pivotgait.models.config import (
    Angle,
    Config,
    Coordinate,
    Name,
    NotNegative,
    Positive,
    Vector2,
    Vector3,
)
from pivotgait.models.robot_config import JointPositions, RobotConfig
from pivotgait.models.validation_config import ValidationConfig

SCHEMA = "pivotgait-scene/1"

Friction = Annotated[FiniteFloat, Field(gt=0, le=2, description="Coulomb coefficient")]
Duration = Annotated[FiniteFloat, Field(gt=0, le=600, description="length of the phase [s]")]
Steps = Annotated[int, Field(ge=2, le=4096, description="number of time steps K")]


class ForceBounds(Config):
    """Bounds of a normal force [N] (Xue et al., eq. 6)."""

    min: NotNegative
    max: Positive


class HandleConfig(Config):
    """The handle and the coordinates on it, in the URDF's root-link frame."""

    shapes: Annotated[tuple[str, ...], Field(min_length=1)]
    """Names of the collision shapes that form the handle."""
    origin_m: Vector3
    """Where ``along_m`` is 0."""
    axis: Vector3
    """Direction of growing ``along_m``, any length."""
    zero: Vector3
    """Direction of ``around_deg`` 0, normal to the axis; the angle is right-handed about it."""


class ToolConfig(Config):
    """The tool: a built-in model's name or a URDF path relative to the scene file."""

    urdf: Annotated[str, Field(min_length=1, max_length=1000)]
    tip: str = "tip"
    """Name of the collision sphere that pivots on the table."""
    handle: HandleConfig


class TableConfig(Config):
    """A horizontal rectangle in the world frame."""

    height_m: Coordinate = 0.0
    centre_m: Vector2
    half_size_m: tuple[Positive, Positive]
    friction: Friction
    normal_force_N: ForceBounds


class RestConfig(Config):
    """How the tool lies at the start; its pitch follows from lying on the table."""

    pivot_m: Vector2
    """World x and y of the pivot."""
    yaw_deg: Angle = 0.0
    roll_deg: Angle = 0.0


class ContactConfig(Config):
    """A place on the handle and the finger that may touch it."""

    finger: Name
    along_m: Coordinate
    around_deg: Angle
    friction: Friction
    normal_force_N: ForceBounds
    torsion_m: Annotated[FiniteFloat, Field(ge=0, le=0.05)] = 0.0
    """Torsional friction of a soft fingertip: largest moment about the normal per normal force."""


class AllocationConfig(Config):
    """How contact forces are chosen among the possible ones."""

    objective: Literal["alignment", "tangential", "effort", "margin"] = "alignment"
    force_rate_max_N_s: Positive = 20.0
    friction_reserve: Annotated[FiniteFloat, Field(ge=0, lt=1)] = 0.0
    """Share of every friction coefficient that the plan leaves unused, against errors."""


class LiftTarget(Config):
    """Attitude after the lift: absolute pitch; roll and yaw relative to the rest."""

    pitch_deg: Annotated[FiniteFloat, Field(gt=-90, lt=90)]
    roll_deg: Angle = 0.0
    yaw_deg: Angle = 0.0


class _Motion(Config):
    """A phase in which the hand moves."""

    posture: JointPositions = Field(default_factory=dict)
    """Of the hand at the phase's end: tried before any search; joints left out are at home."""


class LiftPhase(_Motion):
    """Pivot the tool up from its rest, held by the given contacts."""

    kind: Literal["lift"]
    contacts: Annotated[tuple[Name, ...], Field(min_length=2)]
    duration_s: Duration
    steps: Steps
    profile: Literal["quintic", "trapezoidal"] = "quintic"
    to: LiftTarget
    posture_before: JointPositions = Field(default_factory=dict)
    """Of the hand at the phase's beginning; as at its end if left out."""


class AdditionPhase(Config):
    """Bring a finger to a contact while the tool rests; it may have been elsewhere before."""

    kind: Literal["addition"]
    contact: Name
    duration_s: Duration
    steps: Steps


class RemovalWeights(Config):
    """Weights of the removal's cost (Xue et al., Section IV-A)."""

    reorientation: NotNegative = 1.0
    acceleration: NotNegative = 1e-3
    alignment: NotNegative = 2e-2


class RemovalPhase(_Motion):
    """Unload a finger while the tool pivots to an attitude that the others can hold."""

    kind: Literal["removal"]
    contact: Name
    duration_s: Duration
    steps: Steps
    weights: RemovalWeights = RemovalWeights()
    doubling: bool = False
    """Solve with few steps first and double them."""


class RelocationPhase(_Motion):
    """Move a free finger to a contact along a collision-free path; the others hold the tool."""

    kind: Literal["relocation"]
    contact: Name
    sample_s: Annotated[FiniteFloat, Field(gt=0, le=0.1)] = 0.02
    """Time between the plan's samples; the duration follows from the joints' limits."""
    standoff_m: Annotated[FiniteFloat, Field(ge=0, le=0.05)] = 0.0
    """How far before the contact the fingertip stops, along the normal; from 0, touching it."""


class TransferPhase(Config):
    """Take the tool off the table: the pivot's force fades, the tool rises, then hangs still."""

    kind: Literal["transfer"]
    duration_s: Duration
    steps: Steps
    rise_m: Annotated[FiniteFloat, Field(gt=0, le=0.5)] = 0.05
    """How far the tool rises, straight up, without turning."""


PhaseConfig = Annotated[
    LiftPhase | AdditionPhase | RemovalPhase | RelocationPhase | TransferPhase,
    Field(discriminator="kind"),
]


class SceneConfig(Config):
    """A whole scene file. SI units; world frame z up; angles in degrees."""

    schema_: Annotated[Literal["pivotgait-scene/1"], Field(alias="schema")]
    name: Name
    description: Annotated[str, Field(max_length=2000)] = ""
    tool: ToolConfig
    table: TableConfig
    rest: RestConfig
    gravity_m_s2: Vector3 = (0.0, 0.0, -9.81)
    clearance_m: Annotated[FiniteFloat, Field(ge=0, le=0.1)] = 0.001
    """Smallest distance of tool and hand to what they must not touch."""
    robot: RobotConfig | None = None
    """The arm-hand; without one the plan holds the tool's motion and the forces only."""
    contacts: Annotated[dict[Name, ContactConfig], Field(min_length=2)]
    allocation: AllocationConfig = AllocationConfig()
    validation: ValidationConfig = ValidationConfig()
    """Perturbations of the closed-loop trials."""
    gaits: Annotated[
        dict[Name, Annotated[tuple[PhaseConfig, ...], Field(min_length=1)]], Field(min_length=1)
    ]
