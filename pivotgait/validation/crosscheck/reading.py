"""What an engine makes of a URDF: one interface for all of them, the base fixed in the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple, Protocol, Self

from pivotgait.frozen import Array


class Limits(NamedTuple):
    """Of one joint; infinite where the engine knows none.

    Attributes:
        lower: position [rad] or [m].
        upper: position [rad] or [m].
        effort: largest torque or force [N m] or [N].
    """

    lower: float
    upper: float
    effort: float


class Reading(Protocol):
    """A robot as one engine holds it. Use it as a context: the engine is freed at its end.

    Joint vectors (nv,) are in the order of ``joints``: one coordinate each, angles in rad.
    """

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that move, in the engine's order."""

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links, those fixed to others included."""

    def limits(self) -> Mapping[str, Limits]:
        """Of each joint, by name."""

    def mass_matrix(self, q: Array) -> Array:
        """(nv, nv) joint-space inertia [kg], [kg m] or [kg m^2]."""

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """(nv,) torques of a motion under gravity, without damping and friction."""

    def placements(self, q: Array) -> Mapping[str, Array]:
        """(4, 4) world <- link, by the link's name."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *error: object) -> None: ...


def _pinocchio(urdf: str) -> Reading:
    from pivotgait.validation.crosscheck.pinocchio_ import PinocchioReading

    return PinocchioReading(urdf)


def _pybullet(urdf: str) -> Reading:
    from pivotgait.validation.crosscheck.pybullet_ import PyBulletReading

    return PyBulletReading(urdf)


def _mujoco(urdf: str) -> Reading:
    from pivotgait.validation.crosscheck.mujoco_ import MuJoCoReading

    return MuJoCoReading(urdf)


ENGINES: Mapping[str, Callable[[str], Reading]] = MappingProxyType(
    {"pinocchio": _pinocchio, "pybullet": _pybullet, "mujoco": _mujoco}
)
"""Makers by name, from URDF text without shapes; the first is what the others are held against."""
