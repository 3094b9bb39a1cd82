"""How far the measured grasp is from failing: cones, normal forces, orientation."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, degrees
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, PhaseReference, Reference
from pivotgait.frozen import Array


class GraspMargins(NamedTuple):
    """Margins without units: 1 at best, 0 where the grasp fails.

    Attributes:
        fingers: names of the m fingers that must hold.
        friction: (m,) 1 - |f_t| / (mu f_n) with the friction of the plan; not below -1, and -1
            without force.
        pressing: (m,) measured over least planned normal force; may exceed 1.
        orientation: 1 less the angle from the planned orientation over the largest allowed one.
    """

    fingers: tuple[str, ...]
    friction: Array
    pressing: Array
    orientation: float

    def least(self, *, friction: bool = True) -> tuple[str, float]:
        """The finger, or ``tool`` for the orientation, with the least margin; and that margin.

        Args:
            friction: whether cones count. A sensor that reads a force's direction wrong by some
                degrees puts a sound grasp at the edge of its cones.
        """
        name, least = "tool", self.orientation
        if self.fingers:
            margins = np.minimum(self.friction, self.pressing) if friction else self.pressing
            each = margins.tolist()
            lowest = min(each)
            if lowest < least:
                name, least = self.fingers[each.index(lowest)], lowest
        return name, least


@dataclass(frozen=True, eq=False)
class _Holding:
    """What is constant of the fingers that must hold during a phase."""

    names: tuple[str, ...]
    rows: NDArray[np.intp]
    normals: Array
    friction: Array
    normal_min: Array

    @classmethod
    def of(cls, phase: PhaseReference, fingers: tuple[str, ...]) -> _Holding:
        samples = phase.samples
        changing = samples.finger if samples.kind in ("addition", "removal") else ""
        tracks = [
            samples.contacts[hold.finger.name]
            for hold in phase.holds
            # Before the plan begins the fingers close: none of them must hold yet.
            if hold.finger.name != changing and samples.contacts[hold.finger.name].force[0].any()
        ]
        return cls(
            names=tuple(track.name for track in tracks),
            rows=np.array([fingers.index(track.name) for track in tracks], dtype=int),
            normals=np.array([track.normal for track in tracks]).reshape(-1, 3),
            friction=np.array([track.friction for track in tracks]),
            normal_min=np.array([max(track.normal_min, 1e-9) for track in tracks]),
        )


class GraspMonitor:
    """Margins of the fingers that hold, from low-passed readings.

    Readings are filtered in tool axes, in which planned forces hardly turn.
    """

    def __init__(self, reference: Reference, *, lag_s: float, orientation_deg: float) -> None:
        """A monitor of a plan.

        Args:
            reference: the plan.
            lag_s: time constant of the readings' low pass [s]; 0 for none.
            orientation_deg: angle from the plan that counts as failure [deg].
        """
        self._fingers = tuple(reference.robot.fingers)
        self._holding = tuple(_Holding.of(phase, self._fingers) for phase in reference.phases)
        self._lag, self._largest = lag_s, orientation_deg
        self.reset()

    def reset(self) -> None:
        """Forget the readings."""
        self._filtered: Array | None = None
        self._last = 0.0

    def margins(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> GraspMargins:
        """The margins now.

        Args:
            task: of the phase; not necessarily updated.
            wanted: the plan now.
            measurement: one cycle after the last one.
        """
        holding = self._holding[task.reference.index]
        force = self._forces(measurement)[holding.rows]
        normal = (force * holding.normals).sum(axis=1)
        across = force - normal[:, None] * holding.normals
        tangent = np.sqrt((across * across).sum(axis=1))
        limit = holding.friction * normal
        friction = np.maximum(1.0 - tangent / np.maximum(limit, 1e-9), -1.0)
        friction[limit <= 0.0] = -1.0
        apart = _angle_deg(wanted.tool.rotation, measurement.tool_rotation)
        return GraspMargins(
            holding.names, friction, normal / holding.normal_min, 1.0 - apart / self._largest
        )

    def _forces(self, measurement: Measurement) -> Array:
        """(fingers, 3) low-passed readings, tool axes [N]."""
        given = [measurement.force.get(name, _NONE) for name in self._fingers]
        force = np.array(given).dot(measurement.tool_rotation)
        if self._filtered is None or self._lag == 0.0:
            self._filtered = force
        else:
            step = measurement.time - self._last
            self._filtered = self._filtered + step / (step + self._lag) * (force - self._filtered)
        self._last = measurement.time
        return self._filtered


def _angle_deg(one: Array, other: Array) -> float:
    """Angle between two rotations [deg]."""
    cosine = 0.5 * (float(np.vdot(one, other)) - 1.0)
    return degrees(acos(min(max(cosine, -1.0), 1.0)))


_NONE = np.zeros(3)
