"""The limits a plan must keep: one entry for each residual of the certificate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType


@dataclass(frozen=True)
class Limit:
    """Bound on a residual.

    Attributes:
        bound: in ``unit``.
        unit: SI, empty for a pure number.
        meaning: what the residual measures.
        at_least: whether the residual must not fall below the bound (else: not exceed it).
    """

    bound: float
    unit: str
    meaning: str
    at_least: bool = False

    def holds(self, value: float) -> bool:
        """Whether ``value`` keeps the limit; NaN and infinity never do."""
        if not math.isfinite(value):
            return False
        return value >= self.bound if self.at_least else value <= self.bound


# Identities between stored numbers (unit length, eqs 1 and 2) are evaluated once from float64
# values of order 1 to 10: 1e-9 is a million roundings and still far below anything physical.
_IDENTITY = 1e-9

TOOL_LIMITS: Mapping[str, Limit] = MappingProxyType(
    {
        "force_balance_n": Limit(1e-6, "N", "residual of (3), forces"),
        "moment_balance_nm": Limit(1e-7, "N m", "residual of (3), moments about the mass centre"),
        "cone_margin_n": Limit(-1e-8, "N", "mu f_n - |f_t| in the exact cone (5)", at_least=True),
        "normal_bound_n": Limit(1e-8, "N", "normal force beyond its bounds (6)"),
        "ramp_n": Limit(1e-6, "N", "distance of the changing normal force from its ramp (7), (8)"),
        "free_force_n": Limit(1e-6, "N", "force of a finger that does not touch (any more or yet)"),
        "quaternion_norm": Limit(_IDENTITY, "", "distance of |r| from 1"),
        "position_m": Limit(_IDENTITY, "m", "residual of (1)"),
        "linear_velocity_m_s": Limit(_IDENTITY, "m/s", "residual of the time derivative of (1)"),
        "linear_acceleration_m_s2": Limit(_IDENTITY, "m/s^2", "residual of (2)"),
        "rotation_excess_rad": Limit(
            _IDENTITY, "rad", "orientation step against angular velocity, beyond sampling error"
        ),
        "rate_excess_rad_s": Limit(
            _IDENTITY, "rad/s", "angular velocity step against acceleration, beyond sampling error"
        ),
        "rest_rad_s": Limit(1e-8, "rad/s", "angular speed where phases meet"),
        "pivot_moved_m": Limit(_IDENTITY, "m", "distance of the pivot from the first phase's"),
        "pivot_height_m": Limit(1e-6, "m", "gap or overlap of the tip's sphere and the table"),
        "table_normal": Limit(_IDENTITY, "", "distance of the table's normal from +z"),
        "seam_orientation_rad": Limit(_IDENTITY, "rad", "turn of the tool between two phases"),
        "seam_position_m": Limit(_IDENTITY, "m", "jump of the mass centre between two phases"),
        "seam_force_n": Limit(1e-6, "N", "jump of a contact force between two phases"),
        "seam_contact_m": Limit(_IDENTITY, "m", "jump of a held contact between two phases"),
        "seam_friction": Limit(_IDENTITY, "", "change of a held contact's friction coefficient"),
        "normal_norm": Limit(_IDENTITY, "", "distance of a contact normal's length from 1"),
        "contact_surface_m": Limit(1e-6, "m", "distance of a contact from the tool's surface"),
        "contact_normal_rad": Limit(1e-3, "rad", "angle of a contact normal to the surface's"),
        "tool_mass": Limit(_IDENTITY, "", "mass against the URDF, relative"),
        "tool_inertia": Limit(_IDENTITY, "", "inertia against the URDF, relative"),
        "tool_centre_m": Limit(_IDENTITY, "m", "centre of mass against the URDF"),
        "tool_pivot_m": Limit(1e-6, "m", "pivot against the centre of the URDF's tip sphere"),
        "tool_inertia_physical": Limit(
            -_IDENTITY,
            "",
            "least of principal inertia and triangle sum, relative",
            at_least=True,
        ),
        "lift_clearance_m": Limit(-1e-6, "m", "tool over the table in a lift", at_least=True),
        "table_clearance_m": Limit(1e-3, "m", "tool over the table, other phases", at_least=True),
    }
)
"""What every plan is judged by: tool, contacts and forces."""

ROBOT_LIMITS: Mapping[str, Limit] = MappingProxyType(
    {
        "tip_radius_m": Limit(_IDENTITY, "m", "fingertip's radius against the URDF's sphere"),
        "tip_contact_m": Limit(1e-5, "m", "distance of a holding fingertip from its contact"),
        # A tip of 10 mm that rolls by this angle carries the contact over 1e-6 m, a tenth of the
        # distance that the contact itself may be off.
        "tip_rolling_rad": Limit(1e-4, "rad", "turn of a holding fingertip, but about the normal"),
        # Two samples may lie on opposite sides of the contact, each at its limit.
        "tip_slip_m": Limit(2e-5, "m", "drift of a holding fingertip's touching point on the tool"),
        # Over a step of 10 ms either moves the contact by 1e-8 m or less, a thousandth of its
        # limit; both are far above the rounding of a Jacobian of condition 1e6.
        "tip_velocity_m_s": Limit(1e-6, "m/s", "velocity of a holding fingertip against the tool"),
        "tip_acceleration_m_s2": Limit(1e-4, "m/s^2", "acceleration of it against the tool"),
        "tip_penetration_m": Limit(
            -1e-5, "m", "least distance of a touching fingertip from the tool", at_least=True
        ),
        "joint_position": Limit(_IDENTITY, "rad or m", "joint position beyond its limits"),
        "joint_coupling": Limit(_IDENTITY, "rad or m", "excess of a joint over its coupled one"),
        "joint_speed": Limit(1.0 + _IDENTITY, "", "joint speed relative to its limit"),
        "joint_torque": Limit(1.0 + _IDENTITY, "", "joint torque or force relative to its limit"),
        "joint_step_excess": Limit(
            _IDENTITY, "rad or m", "joint step against its speed, beyond sampling error"
        ),
        "joint_rate_excess": Limit(
            _IDENTITY, "rad/s or m/s", "joint speed step against acceleration, beyond sampling"
        ),
        "joint_rest": Limit(1e-8, "rad/s or m/s", "joint speed where phases meet"),
        "seam_joint": Limit(_IDENTITY, "rad or m", "jump of a joint between two phases"),
        "torque_balance_nm": Limit(1e-6, "N m or N", "residual of (17)"),
        "hand_clearance_m": Limit(
            1e-3, "m", "robot to itself, tool and table outside the wanted contacts", at_least=True
        ),
    }
)
"""What a plan with an arm-hand is judged by besides :data:`TOOL_LIMITS`."""

TRANSFER_LIMITS: Mapping[str, Limit] = MappingProxyType(
    {
        "rise_excess_m": Limit(
            _IDENTITY, "m", "step of the mass centre against its speed, beyond sampling error"
        ),
        "rise_rate_excess_m_s": Limit(
            _IDENTITY, "m/s", "its speed step against acceleration, beyond sampling error"
        ),
        "rest_m_s": Limit(1e-8, "m/s", "speed of the tool at both ends of a transfer"),
        "borne_tip_m": Limit(_IDENTITY, "m", "tip off the pivot while the table pushes on it"),
        "tip_depth_m": Limit(1e-6, "m", "depth of the tip's sphere in the table"),
        "seam_moment_nm": Limit(1e-7, "N m", "jump of a contact's moment between two phases"),
    }
)
"""What a plan that takes the tool off the table is judged by besides :data:`TOOL_LIMITS`."""

LIMITS: Mapping[str, Limit] = MappingProxyType({**TOOL_LIMITS, **ROBOT_LIMITS, **TRANSFER_LIMITS})
"""Residual's name -> its limit; the tolerances that a plan is judged by unless told otherwise."""


def with_clearance(clearance: float, limits: Mapping[str, Limit] = LIMITS) -> Mapping[str, Limit]:
    """The limits with another least distance [m]: tool to table outside lifts, and robot to all."""
    changed = {
        what: replace(limits[what], bound=clearance)
        for what in ("table_clearance_m", "hand_clearance_m")
    }
    return MappingProxyType({**limits, **changed})
