"""The arm-hand: one Pinocchio model, its palm, and its fingers as the planners see them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pivotgait.frozen import Array, FrozenArrays


@dataclass(frozen=True, eq=False)
class Finger(FrozenArrays):
    """A finger whose tip is a sphere about the origin of its tip frame.

    Attributes:
        name: by which contacts call it.
        tip_frame: name of the frame at the tip's centre, also that of the tip's link.
        tip_frame_id: its index in the Pinocchio model.
        tip_radius: of the tip's sphere [m].
        pad: (3,) unit direction from the tip's centre to the middle of its pad, tip frame.
        pad_cone: largest angle between ``pad`` and the direction to a contact [rad].
        joints: names of its joints, from the palm outwards.
        columns: their places in configuration, velocity and torque.
    """

    name: str
    tip_frame: str
    tip_frame_id: int
    tip_radius: float
    pad: Array
    pad_cone: float
    joints: tuple[str, ...]
    columns: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Robot(FrozenArrays):
    """An arm-hand with its base placed in the world; every joint has one coordinate (nq = nv).

    Attributes:
        name: of the URDF's robot.
        urdf: the whole text; its root is the world frame (a base placed elsewhere stands in it).
        model: ``pinocchio.Model``; the gravity of a scene's robot is the scene's.
        collision: ``pinocchio.GeometryModel`` of primitives, with the pairs of links that must
            not touch one another; neighbours are left out.
        palm_frame: name of the frame that carries the fingers.
        palm_frame_id: its index.
        palm_columns: places of the joints that belong to no finger: arm and wrist (q_h).
        fingers: by name.
        lower: (nv,) joint limits [rad] or [m].
        upper: (nv,) joint limits [rad] or [m].
        velocity_max: (nv,) [rad/s] or [m/s].
        acceleration_max: (nv,) [rad/s^2] or [m/s^2].
        effort_max: (nv,) [N m] or [N].
        couplings: pairs (i, k) of columns with the rule q_i <= q_k.
        never_touch: pairs of link names whose distance does not count, besides neighbours.
        home: (nv,) a comfortable posture within the limits, to which unused freedom returns.
    """

    name: str
    urdf: str
    model: Any
    collision: Any
    palm_frame: str
    palm_frame_id: int
    palm_columns: tuple[int, ...]
    fingers: Mapping[str, Finger]
    lower: Array
    upper: Array
    velocity_max: Array
    acceleration_max: Array
    effort_max: Array
    couplings: tuple[tuple[int, int], ...]
    never_touch: tuple[tuple[str, str], ...]
    home: Array

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.model.nv)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints in the order of q."""
        return tuple(self.model.names[1:])

    def posture(self, positions: Mapping[str, float]) -> Array:
        """(nv,) joint positions by name [rad] or [m]; joints left out are at home."""
        q = np.array(self.home)
        for joint, value in positions.items():
            q[self.joint_names.index(joint)] = value
        return q

    def beyond_range(self, q: Array) -> Array:
        """How far each coordinate of q (..., nv) is beyond its joint limits; negative within."""
        return np.maximum(self.lower - q, q - self.upper)

    def beyond_limits(self, q: Array) -> Array:
        """How far each of q (..., nv) is beyond joint limits and couplings; negative within."""
        beyond = self.beyond_range(q)
        for i, k in self.couplings:
            beyond[..., i] = np.maximum(beyond[..., i], q[..., i] - q[..., k])
        return beyond

    def within_limits(self, q: Array, slack: float = 0.0) -> bool:
        """Whether q (nv,) or (N, nv) keeps joint limits and couplings up to ``slack``."""
        inside = np.all(q >= self.lower - slack) and np.all(q <= self.upper + slack)
        return bool(inside) and all(
            bool(np.all(q[..., i] <= q[..., k] + slack)) for i, k in self.couplings
        )
