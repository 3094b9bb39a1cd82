"""The tool along a finger's path: at rest, or turning about its pivot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array, FrozenArrays, frozen
from pivotgait.kinematics.rigid_motion import RigidMotion

AT_REST = RigidMotion(np.zeros(3), np.zeros(3))


class ToolPath(Protocol):
    """Where the tool is at a path parameter s in [0, 1]; twice differentiable in s."""

    @property
    def moves(self) -> bool:
        """Whether the pose depends on s."""
        ...

    def pose(self, s: float) -> tuple[Array, Array]:
        """Orientation (3, 3), world <- tool, and centre of mass (3,), world [m]."""
        ...

    def motion(self, s: float, rate: float, acceleration: float) -> RigidMotion:
        """Velocity and acceleration for ds/dt [1/s] and d2s/dt2 [1/s^2]."""
        ...


@dataclass(frozen=True, eq=False)
class PivotingTool(FrozenArrays):
    """A tool that turns about a fixed axis through its pivot (Xue et al., eqs 1 and 2), or rests.

    Attributes:
        oRtool: (3, 3) orientation at s = 0, world <- tool.
        position: (3,) centre of mass at s = 0, world [m].
        pivot: (3,) fixed point, world [m].
        turn: (3,) rotation from s = 0 to s = 1 as a vector, world [rad]; zero for a resting tool.

    Raises:
        InputError: for numbers that are not finite.
    """

    oRtool: Array
    position: Array
    pivot: Array
    turn: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("oRtool", "position", "pivot", "turn"):
            if not np.all(np.isfinite(getattr(self, name))):
                raise InputError("is not finite", where=f"tool's {name}", mend="look for NaN")

    @classmethod
    def resting(cls, oRtool: Array, position: Array) -> PivotingTool:
        """A tool that stays where it is."""
        return cls(oRtool, position, position, np.zeros(3))

    @cached_property
    def moves(self) -> bool:
        """Whether the tool turns at all."""
        return bool(np.any(self.turn))

    @cached_property
    def _start(self) -> tuple[Array, Array]:
        return frozen(self.oRtool), frozen(self.position)

    def pose(self, s: float) -> tuple[Array, Array]:
        """Orientation (3, 3), world <- tool, and centre of mass (3,), world [m]."""
        if not self.moves:
            return self._start
        turned = Rotation.from_rotvec(s * self.turn).as_matrix()
        return turned @ self.oRtool, self.pivot + turned @ (self.position - self.pivot)

    def motion(self, s: float, rate: float, acceleration: float) -> RigidMotion:
        """Velocity and acceleration for ds/dt [1/s] and d2s/dt2 [1/s^2]."""
        if not self.moves:
            return AT_REST
        omega, change = rate * self.turn, acceleration * self.turn
        lever = self.pose(s)[1] - self.pivot
        velocity = np.cross(omega, lever)
        return RigidMotion(
            linear_velocity=velocity,
            angular_velocity=omega,
            linear_acceleration=np.cross(change, lever) + np.cross(omega, velocity),
            angular_acceleration=change,
        )
