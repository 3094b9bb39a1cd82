"""What the plan wants at the times of a run: the yardstick of verdict and metrics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.support import covering_balls, height_over_table
from pivotgait.models.urdf import check_urdf
from pivotgait.plans import PIVOT, GaitPlan, Phase


@dataclass(frozen=True, eq=False)
class Planned(FrozenArrays):
    """The plan at N times; before its start its first sample, after its end its last.

    Attributes:
        phase: (N,) index of the phase, as a float; the number of phases in the final hold.
        orientation: (N, 4) of the tool, xyzw, world <- tool.
        force: (N, fingers, 3) on the tool, **tool axes** [N], 0 where a finger has no contact.
        friction: (N, fingers) coefficients, 0 where a finger has no contact.
        pivot_force: (N, 3) of the table on the tip, world [N].
        pivot_friction: (N,) coefficient of tip and table.
        normal: (N, fingers, 3) inward normals in the tool frame, 0 where a finger has no contact.
        holds: (N, fingers) 1 where a finger must touch the tool, else 0.
        loads: (N, fingers) 1 where a finger's force grows from or shrinks to zero.
        free: (N, fingers) 1 where a finger has no business at the tool.
        carried: (N,) 1 from a transfer's start on, when the tip need not bear on the table, else 0.
        rise: (N,) of the tip over where it stands on the table [m].
        height: (N,) of the tool's lowest point, but the tip, over the table [m].
    """

    phase: Array
    orientation: Array
    force: Array
    friction: Array
    pivot_force: Array
    pivot_friction: Array
    normal: Array
    holds: Array
    loads: Array
    free: Array
    carried: Array
    rise: Array
    height: Array

    def every(self, step: int) -> Planned:
        """Each ``step``-th instant."""
        return Planned(**{name: values[::step] for name, values in vars(self).items()})

    @property
    def rotation(self) -> Rotation:
        """The N orientations."""
        return Rotation.from_quat(self.orientation)

    @property
    def normal_force(self) -> Array:
        """(N, fingers) [N], 0 where a finger has no contact."""
        return np.asarray(np.einsum("nki,nki->nk", self.force, self.normal))


def planned_at(plan: GaitPlan, time: Array, fingers: tuple[str, ...]) -> Planned:
    """The plan at ``time`` (N,) [s] since its start."""
    ends = np.cumsum([phase.duration_s for phase in plan.phases])
    index = np.searchsorted(ends, time, side="right")
    inside = np.minimum(index, len(ends) - 1)
    local = np.clip(time - (ends - [p.duration_s for p in plan.phases])[inside], 0.0, None)
    columns = _Columns.empty(len(time), len(fingers))
    for place, phase in enumerate(plan.phases):
        rows = np.flatnonzero(inside == place)
        if len(rows):
            columns.fill(phase, rows, np.minimum(local[rows], phase.duration_s), fingers)
    columns.settle(plan.phases[-1], index == len(ends), fingers)
    return Planned(
        phase=index.astype(float),
        height=_tool_height(plan, Rotation.from_quat(columns.orientation)) + columns.rise,
        **vars(columns),
    )


@dataclass
class _Columns:
    """The columns of :class:`Planned` while they are filled."""

    orientation: Array
    force: Array
    friction: Array
    pivot_force: Array
    pivot_friction: Array
    normal: Array
    holds: Array
    loads: Array
    free: Array
    carried: Array
    rise: Array

    @classmethod
    def empty(cls, count: int, fingers: int) -> _Columns:
        flat, deep = (count, fingers), (count, fingers, 3)
        return cls(
            orientation=np.zeros((count, 4)),
            force=np.zeros(deep),
            friction=np.zeros(flat),
            pivot_force=np.zeros((count, 3)),
            pivot_friction=np.zeros(count),
            normal=np.zeros(deep),
            holds=np.zeros(flat),
            loads=np.zeros(flat),
            free=np.ones(flat),
            carried=np.zeros(count),
            rise=np.zeros(count),
        )

    def fill(
        self, phase: Phase, rows: NDArray[np.intp], at: Array, fingers: tuple[str, ...]
    ) -> None:
        """One phase's rows, at times [s] since its start."""
        since = phase.time - phase.time[0]
        turn = phase.tool.rotation
        self.orientation[rows] = Slerp(since, turn)(at).as_quat(canonical=True)
        pivot = phase.contacts[PIVOT]
        self.pivot_force[rows] = _between(at, since, pivot.force)
        self.pivot_friction[rows] = pivot.friction
        if phase.kind == "transfer":
            self.carried[rows] = 1.0
            rise = phase.tool.position[:, 2] - phase.tool.position[0, 2]
            self.rise[rows] = np.interp(at, since, rise)
        for k, name in enumerate(fingers):
            track = phase.contacts.get(name)
            if track is None or (phase.kind == "relocation" and name == phase.finger):
                continue
            in_tool = np.einsum("nji,nj->ni", turn.as_matrix(), track.force)
            self.force[rows, k] = _between(at, since, in_tool)
            self.friction[rows, k], self.normal[rows, k] = track.friction, track.normal
            changes = _changes(phase, name)
            self.loads[rows, k], self.holds[rows, k] = changes, not changes
            self.free[rows, k] = 0.0

    def settle(self, last: Phase, after: NDArray[np.bool_], fingers: tuple[str, ...]) -> None:
        """In the final hold a finger that came holds; one that left is free.

        One that was relocated stands at its contact without force: touching or not, both are fine.
        """
        for k, name in enumerate(fingers):
            if last.kind == "relocation" and name == last.finger:
                self.free[after, k] = 0.0
            if name in last.contacts and _changes(last, name):
                stays = np.any(self.force[after, k] != 0.0, axis=1)
                self.loads[after, k], self.holds[after, k] = 0.0, stays
                self.free[after, k] = ~stays


def _between(at: Array, time: Array, samples: Array) -> Array:
    """(rows, 3) straight lines between samples (N, 3)."""
    return np.stack([np.interp(at, time, samples[:, i]) for i in range(3)], axis=1)


def _tool_height(plan: GaitPlan, rotation: Rotation) -> Array:
    """(N,) height of the tool's lowest point, but the tip, while the tip is on the table [m]."""
    shapes = check_urdf(plan.tool.urdf, where="tool of the plan").collisions
    placed = [shape.shifted(plan.tool.centre_of_mass_in_root) for shape in shapes]
    tip = [np.allclose(each.translation, plan.tool.pivot_in_tool, atol=1e-6) for each in placed]
    radius = max((each.size[0] for each, is_tip in zip(placed, tip, strict=True) if is_tip))
    balls = covering_balls(each for each, is_tip in zip(placed, tip, strict=True) if not is_tip)
    return height_over_table(*balls, plan.tool.pivot_in_tool, radius, rotation.as_matrix())


def _changes(phase: Phase, finger: str) -> bool:
    """Whether a finger's force comes from zero or goes to zero in a phase."""
    return finger == phase.finger and phase.kind != "relocation"
