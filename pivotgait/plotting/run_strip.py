"""A run at a glance: tool and hand where they really were."""

from __future__ import annotations

from typing import Any

from pivotgait.plans.plan import GaitPlan
from pivotgait.plotting.picture import Moment
from pivotgait.plotting.run_replay import held, replay
from pivotgait.plotting.snapshots import draw_strip
from pivotgait.plotting.style import PAGE_WIDTH, styled
from pivotgait.plotting.timeline import phase_title, spans
from pivotgait.validation.record_reading import RecordedMotion


@styled
def run_strip(
    plan: GaitPlan, motion: RecordedMotion, *, columns: int = 4, width: float = PAGE_WIDTH
) -> Any:
    """Tool, hand and measured forces at the start and the end of every phase and of the hold.

    A run that was broken off ends with its last instant.

    Args:
        plan: that was carried out.
        motion: the record of its run.
        columns: most pictures beside each other.
        width: of the figure [in].

    Returns:
        A matplotlib ``Figure``.

    Raises:
        UrdfError: if the robot's URDF is broken.
    """
    run = replay(plan, motion)
    timeline = spans(run)
    moments = [Moment(span.phase, len(span.phase.time) - 1) for span in timeline]
    titles = [f"{phase_title(span.phase)}\n{span.end:.2f} s" for span in timeline]
    first = run.phases[0]
    hold = held(plan, motion)
    if hold is not None:
        moments.append(Moment(hold, 0))
        titles.append(f"final hold\n{motion.series.time[-1]:.2f} s")
    moments.insert(0, Moment(first, 0))
    return draw_strip(plan, moments, ["start", *titles], columns=columns, width=width)
