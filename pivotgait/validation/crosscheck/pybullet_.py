"""A robot as Bullet reads it."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.validation.crosscheck.reading import Limits

_GRAVITY = -9.81


class PyBulletReading:
    """See :class:`Reading`, in a client of its own. A mimic joint is one of its own.

    Inertias are read from the file; a link without any weighs 1 kg in Bullet.
    """

    def __init__(self, urdf: str) -> None:
        import pybullet

        self._bullet: Any = pybullet
        self._client = {"physicsClientId": int(pybullet.connect(pybullet.DIRECT))}
        try:
            pybullet.setGravity(0.0, 0.0, _GRAVITY, **self._client)
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "robot.urdf"
                file.write_text(urdf, encoding="utf-8")
                flags = pybullet.URDF_USE_INERTIA_FROM_FILE
                self._robot = pybullet.loadURDF(
                    str(file), useFixedBase=True, flags=flags, **self._client
                )
            count = range(pybullet.getNumJoints(self._robot, **self._client))
            infos = [pybullet.getJointInfo(self._robot, k, **self._client) for k in count]
        except BaseException:
            pybullet.disconnect(**self._client)
            raise
        self._infos = infos
        self._moving = [info for info in infos if info[2] != pybullet.JOINT_FIXED]
        self._base = pybullet.getBodyInfo(self._robot, **self._client)[0].decode()

    @property
    def joints(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        return tuple(info[1].decode() for info in self._moving)

    @property
    def links(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        return (self._base, *(info[12].decode() for info in self._infos))

    def limits(self) -> Mapping[str, Limits]:
        """See :class:`Reading`."""
        found = {}
        for info in self._moving:
            lower, upper, effort = map(float, info[8:11])
            if lower > upper:  # how Bullet says that there is none
                lower, upper = -np.inf, np.inf
            found[info[1].decode()] = Limits(lower, upper, effort)
        return found

    def mass_matrix(self, q: Array) -> Array:
        """See :class:`Reading`."""
        found = self._bullet.calculateMassMatrix(self._robot, q.tolist(), **self._client)
        return np.array(found)

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """See :class:`Reading`."""
        given = [each.tolist() for each in (q, v, a)]
        found = self._bullet.calculateInverseDynamics(self._robot, *given, **self._client)
        return np.array(found)

    def placements(self, q: Array) -> Mapping[str, Array]:
        """See :class:`Reading`."""
        bullet, found = self._bullet, {}
        for info, position in zip(self._moving, q, strict=True):
            bullet.resetJointState(self._robot, info[0], float(position), **self._client)
        for info in self._infos:
            state = bullet.getLinkState(
                self._robot, info[0], computeForwardKinematics=1, **self._client
            )
            found[info[12].decode()] = _pose(state[4], state[5])
        found[self._base] = np.eye(4)
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._bullet.disconnect(**self._client)


def _pose(position: Any, orientation: Any) -> Array:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_quat(orientation).as_matrix(), position
    return pose
