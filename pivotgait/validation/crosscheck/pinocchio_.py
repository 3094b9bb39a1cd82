"""A robot as Pinocchio reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
import pinocchio as pin

from pivotgait.frozen import Array
from pivotgait.validation.crosscheck.reading import Limits


class PinocchioReading:
    """See :class:`Reading`. A mimic joint is one of its own."""

    def __init__(self, urdf: str) -> None:
        self._model = pin.buildModelFromXML(urdf)
        self._data = self._model.createData()

    @property
    def joints(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        return tuple(self._model.names[1:])

    @property
    def links(self) -> tuple[str, ...]:
        """See :class:`Reading`."""
        frames = self._model.frames
        return tuple(each.name for each in frames if each.type == pin.FrameType.BODY)

    def limits(self) -> Mapping[str, Limits]:
        """See :class:`Reading`."""
        model, found = self._model, {}
        for name, joint in zip(self.joints, model.joints[1:], strict=True):
            effort = float(model.upperEffortLimit[joint.idx_v])
            lower, upper = -np.inf, np.inf
            if joint.nq == 1:  # else continuous: cosine and sine of its angle
                lower = float(model.lowerPositionLimit[joint.idx_q])
                upper = float(model.upperPositionLimit[joint.idx_q])
            found[name] = Limits(lower, upper, effort)
        return found

    def mass_matrix(self, q: Array) -> Array:
        """See :class:`Reading`."""
        upper = np.triu(pin.crba(self._model, self._data, self._placed(q)))
        return np.asarray(upper + np.triu(upper, 1).T)

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """See :class:`Reading`."""
        return np.array(pin.rnea(self._model, self._data, self._placed(q), v, a))

    def placements(self, q: Array) -> Mapping[str, Array]:
        """See :class:`Reading`."""
        pin.framesForwardKinematics(self._model, self._data, self._placed(q))
        frames = zip(self._model.frames, self._data.oMf, strict=True)
        return {
            frame.name: np.array(place.homogeneous)
            for frame, place in frames
            if frame.type == pin.FrameType.BODY
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        return None

    def _placed(self, q: Array) -> Array:
        """Pinocchio's coordinates: cosine and sine for a continuous joint."""
        found = pin.neutral(self._model)
        for joint in list(self._model.joints)[1:]:
            angle = q[joint.idx_v]
            if joint.nq == 1:
                found[joint.idx_q] = angle
            else:
                found[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        return np.asarray(found)
