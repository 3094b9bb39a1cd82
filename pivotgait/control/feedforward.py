"""The hybrid law without force control: a baseline."""

from __future__ import annotations

from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant
from pivotgait.control.task_controller import TaskController
from pivotgait.frozen import Array


class FeedForwardController(TaskController):
    """All of a finger's coordinates by position (12), z too; the planned forces are fed forward.

    It reads no forces. Its stiffness along the normal is the fingertip's apparent mass times K_p.
    """

    def resolved_normal(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(12) of z, the fingertip's surface at that of the planned tool."""
        gains, rows = self.gains, task.z_rows
        resolved: Array = task.feed_forward[rows] + gains.velocity * task.rate_error[rows]
        return resolved + gains.position * task.error[rows]
