"""Hybrid position/impedance control of arm, fingers and tool (Xue et al., Section VI)."""

from __future__ import annotations

from pivotgait.control.gains import HybridGains
from pivotgait.control.measurement import Measurement
from pivotgait.control.phase_task import PhaseTask
from pivotgait.control.reference import Instant, Reference
from pivotgait.control.task_controller import TaskController, measured_normal, planned_normal
from pivotgait.control.tool_feedback import ToolGains
from pivotgait.frozen import Array

DEFAULT_TOOL_GAINS = ToolGains()


class HybridController(TaskController):
    """Angles and tangents by position (12), the normal by impedance (14).

    Of the measured forces only the part along the planned normal is used, and only in (14). The
    measured tool turns the planned forces, and :class:`ToolFeedback` corrects them.
    """

    def __init__(
        self,
        reference: Reference,
        gains: HybridGains | None = None,
        *,
        tool_gains: ToolGains | None = DEFAULT_TOOL_GAINS,
    ) -> None:
        """A controller of one run after another; see :class:`TaskController`.

        Args:
            reference: the plan.
            gains: of the fingers; the default ones if not given.
            tool_gains: of the forces that turn the tool back; None for the paper's law without.
        """
        super().__init__(reference, gains, tool_gains=tool_gains)

    def resolved_normal(self, task: PhaseTask, wanted: Instant, measurement: Measurement) -> Array:
        """(14): z_d'' + (f_nd - f_n + k_v dz_e/dt + k_p z_e) / k_m, with z_d = f_nd / k_e."""
        gains, rows = self.gains, task.z_rows
        planned = planned_normal(task, wanted)
        error = task.error[rows] + planned / gains.contact_stiffness
        pressing = planned - measured_normal(task, wanted, measurement)
        pressing += gains.impedance_damping * task.rate_error[rows]
        pressing += gains.impedance_stiffness * error
        resolved: Array = task.feed_forward[rows] + pressing / gains.impedance_mass
        return resolved
