"""The figure of a plan in two engines: drawn by ``plotting``, saved, and described in words."""

from __future__ import annotations

from pathlib import Path

from pivotgait import plotting
from pivotgait.plans.plan import GaitPlan
from pivotgait.reporting.figures import drawing
from pivotgait.reporting.page import Picture
from pivotgait.reporting.verdict import engine_name
from pivotgait.validation.comparison_files import RecordedComparison


def draw_comparison(
    plan: GaitPlan, compared: RecordedComparison, folder: Path
) -> dict[str, Picture]:
    """Draw both engines beside the plan and save the figure in ``folder`` as PDF and PNG.

    Returns:
        The picture by its name; none where a run ended before it could be drawn.

    Raises:
        OSError: if the folder cannot be written.
    """
    motions = {run.simulator: run.motion for run in compared.runs if run.motion is not None}
    if len(motions) < len(compared.runs):
        return {}
    one, two = map(engine_name, motions)
    caption = (
        f"{one} (drawn through) and {two} (dashed) beside the plan (pale): normal force of each "
        "finger, error of the orientation, slip of the tip and largest slip of a fingertip."
    )
    figure = plotting.comparison(plan, motions)
    image = drawing(figure, folder, "comparison")
    return {"comparison": Picture(image, alt=caption, caption=caption, engines=True)}
