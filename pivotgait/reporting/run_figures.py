"""The figures of a closed-loop run: drawn by ``plotting``, saved, and described in words."""

from __future__ import annotations

from pathlib import Path

from pivotgait import plotting
from pivotgait.plans.plan import GaitPlan
from pivotgait.reporting.figures import drawing, rendering
from pivotgait.reporting.page import Picture
from pivotgait.reporting.verdict import simulator_name
from pivotgait.validation.record_reading import RecordedRun


def draw_run_figures(plan: GaitPlan, run: RecordedRun, folder: Path) -> dict[str, Picture]:
    """Draw every figure of a run of ``plan`` and save it in ``folder`` as PDF and PNG.

    Returns:
        The pictures by name, all of them ``run_...``; none where nothing ran.

    Raises:
        OSError: if the folder cannot be written.
    """
    motion = run.motion
    if motion is None:
        return {}
    where = simulator_name(run)
    narrow = plotting.run_strip(plan, motion, columns=2, width=plotting.COLUMN_WIDTH)
    pictures = {
        "run_strip": Picture(
            rendering(plotting.run_strip(plan, motion), folder, "run_strip"),
            alt=f"The {plan.tool.name} and the hand as {where} moved them, phase by phase.",
            caption=f"The run in {where}: tool and hand where they were, and the measured forces, "
            "at the start and at the end of every phase.",
            narrow=plotting.figure_bytes(narrow, "webp"),
            run=True,
        )
    }
    drawings = {
        "run_normal_forces": (
            plotting.run_normal_forces,
            "Measured normal forces (thin) upon the planned ones (pale), between their bounds.",
        ),
        "run_angles": (
            plotting.run_angles,
            "Angles between measured forces and normals (thin) upon the planned ones (pale); at "
            "the dashed friction angle a contact slips.",
        ),
        "run_deviations": (
            plotting.run_deviations,
            "Slip of tip and fingertips since they arrived, and error of the orientation, below "
            "the limits at which a run has failed.",
        ),
        "run_torques": (
            plotting.run_torques,
            "Torque or force that the controller asked of every joint over its limit.",
        ),
    }
    for name, (draw, caption) in drawings.items():
        pictures[name] = Picture(
            drawing(draw(plan, motion), folder, name),
            alt=f"{caption} Over the time of the run.",
            caption=caption,
            run=True,
        )
    return pictures
