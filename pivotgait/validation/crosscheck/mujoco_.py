"""A robot as MuJoCo reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import numpy as np

from pivotgait.frozen import Array
from pivotgait.validation.crosscheck.reading import Limits
from pivotgait.validation.mujoco_model_ import slashed, write_no_log

_GRAVITY = (0.0, 0.0, -9.81)


class MuJoCoReading:
    """See :class:`Reading`. Links fixed to others are kept; a link of no weight may not move."""

    def __init__(self, urdf: str) -> None:
        import mujoco

        write_no_log()
        self._mujoco: Any = mujoco
        spec = mujoco.MjSpec.from_string(slashed(urdf))
        spec.compiler.fusestatic = False
        spec.option.gravity = _GRAVITY
        self._model: Any = spec.compile()
        self._data: Any = mujoco.MjData(self._model)

    @property
    def joints(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        return tuple(self._model.joint(k).name[1:] for k in range(self._model.njnt))

    @property
    def links(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        return tuple(self._model.body(k).name[1:] for k in range(1, self._model.nbody))

    def limits(self) -> Mapping[str, Limits]:
        """See :class:`Reading`."""
        model, found = self._model, {}
        for k, name in enumerate(self.joints):
            lower, upper, effort = -np.inf, np.inf, np.inf
            if model.jnt_limited[k]:
                lower, upper = model.jnt_range[k].tolist()
            if model.jnt_actfrclimited[k]:
                effort = float(model.jnt_actfrcrange[k, 1])
            found[name] = Limits(lower, upper, effort)
        return found

    def mass_matrix(self, q: Array) -> Array:
        """See :class:`Reading`."""
        self._place(q)
        mass = np.zeros((self._model.nv, self._model.nv))
        self._mujoco.mj_fullM(self._model, self._data, mass)
        return mass

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """See :class:`Reading`."""
        data = self._data
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        self._mujoco.mj_inverse(self._model, data)
        # MuJoCo leaves out what damping, dry friction and limits do
        return np.asarray(data.qfrc_inverse + data.qfrc_passive + data.qfrc_constraint)

    def placements(self, q: Array) -> Mapping[str, Array]:
        """See :class:`Reading`."""
        self._place(q)
        found = {}
        for k, name in enumerate(self.links, start=1):
            pose = np.eye(4)
            pose[:3, :3] = self._data.xmat[k].reshape(3, 3)
            pose[:3, 3] = self._data.xpos[k]
            found[name] = pose
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        del self._data, self._model

    def _place(self, q: Array) -> None:
        self._data.qpos[:] = q
        self._mujoco.mj_fwdPosition(self._model, self._data)
