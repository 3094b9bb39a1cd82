"""What a run leaves behind: every control cycle, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pivotgait.control.recovery_event import RecoveryEvent
from pivotgait.frozen import Array, FrozenArrays


@dataclass(frozen=True, eq=False)
class RunSeries(FrozenArrays):
    """N control cycles of one run. The fingers' order is that of ``fingers``.

    Attributes:
        fingers: names.
        joint_names: in the order of q.
        time: (N,) since the plan's start [s]; negative while the fingers close.
        q: (N, nv) joint positions.
        v: (N, nv) joint velocities.
        tau: (N, nv) torques asked for by the controller [N m] or [N], before the limits.
        tool_position: (N, 3) centre of mass, world [m].
        tool_orientation: (N, 4) unit quaternion xyzw, world <- tool.
        force: (N, fingers, 3) true force on the tool, world [N].
        reading: (N, fingers, 3) what the controller read of it.
        pivot_force: (N, 3) true force of the table on the tip, world [N].
        touches: (N_i,) times [s] at which each pair that should never touch did, by its names.
        touching_table: (M,) times [s] at which the table bore the tool elsewhere than at the tip.
        diverged: why the run was broken off, empty if it was not.
        pivot_in_tool: (3,) of the real tool [m].
        plan_time: (N,) time of the plan that was followed [s]; None where it is ``time``.
        recovery: what was done to save the grasp.
    """

    fingers: tuple[str, ...]
    joint_names: tuple[str, ...]
    time: Array
    q: Array
    v: Array
    tau: Array
    tool_position: Array
    tool_orientation: Array
    force: Array
    reading: Array
    pivot_force: Array
    touches: Mapping[str, Array]
    touching_table: Array
    diverged: str
    pivot_in_tool: Array
    plan_time: Array | None = None
    recovery: tuple[RecoveryEvent, ...] = ()

    @property
    def followed(self) -> Array:
        """(N,) time of the plan that was followed [s]."""
        return self.time if self.plan_time is None else self.plan_time

    def every(self, step: int) -> RunSeries:
        """Each ``step``-th cycle; the times of touches stay."""
        return self._rows(slice(None, None, step))

    def first(self, count: int) -> RunSeries:
        """The first ``count`` cycles; the times of touches stay."""
        return self._rows(slice(count))

    def _rows(self, rows: slice) -> RunSeries:
        kept = {name: getattr(self, name)[rows] for name in (*_PER_CYCLE, "time")}
        if self.plan_time is not None:
            kept["plan_time"] = self.plan_time[rows]
        return replace(self, **kept)


_PER_CYCLE = (
    "q",
    "v",
    "tau",
    "tool_position",
    "tool_orientation",
    "force",
    "reading",
    "pivot_force",
)
