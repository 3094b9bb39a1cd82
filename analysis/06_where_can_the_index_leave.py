"""Where must the middle finger be so that the index finger can leave the knife?

After the lift thumb, index and middle finger hold the knife; the index leaves. Two maps over the
place of the middle finger, along and around the handle, for three frictions of the fingers:

* **at rest**: do thumb and middle finger hold the knife just as it stands, and with what room?
* **with pivoting**: by how much must it turn about a horizontal axis until they hold it?

The border is traced by refinement about it, see :func:`pivotgait.feasibility.trace_map`. Friction
counts without the scene's reserve, as it does for plans.
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from rich.console import Console
from study_files import run_from_command_line, write_results

from pivotgait.feasibility import FeasibilityMap, MapAxis, Question, Variants, trace_slices
from pivotgait.models import load_scene
from pivotgait.plotting import feasibility_maps, save_figure

OUT = Path("reports/out/analysis/06")
SCENE, MOVED = "knife", "middle_flat"
ALONG_M, AROUND_DEG = (0.010, 0.108), (60.0, 210.0)
FRICTION = (0.6, 0.8, 1.0)
TOLERANCE, TURN_TOLERANCE = 1.0 / 128.0, 1.0 / 32.0


def main(quick: bool = False, out: Path = OUT) -> dict[str, Any]:
    """Run the study; write ``places_at_rest``, ``places_with_pivoting`` and ``places.json``.

    Args:
        quick: one friction and coarse borders.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, scene = Console(), load_scene(SCENE)
    variants, friction = Variants(scene), FRICTION[1:2] if quick else FRICTION
    across = MapAxis(f"contacts.{MOVED}.along_m", *ALONG_M)
    up = MapAxis(f"contacts.{MOVED}.around_deg", *AROUND_DEG)
    slices = [("contacts.*.friction", each) for each in friction]
    result: dict[str, Any] = {"scene": SCENE, "moved": MOVED}
    wanted = {
        "places_at_rest": ("depth", 1.0 / 16.0 if quick else TOLERANCE),
        "places_with_pivoting": ("turn", 1.0 / 8.0 if quick else TURN_TOLERANCE),
    }
    for name, (quantity, tolerance) in wanted.items():
        began = perf_counter()
        question = Question.about(scene, quantity=quantity)
        maps = trace_slices(variants, question, across, up, slices, tolerance=tolerance)
        save_figure(feasibility_maps(maps), out, name)
        result[name] = [findings(each, mu) for each, mu in zip(maps, friction, strict=True)]
        for row in result[name]:
            console.print(
                f"{name}, friction {row['friction']:g}: {100 * row['area']:.1f} % of the places, "
                f"{row['evaluated']} points instead of {row['grid']}"
            )
        console.print(f"{name}: {perf_counter() - began:.1f} s")
    write_results(out / "places.json", result)
    return result


def findings(found: FeasibilityMap, friction: float) -> dict[str, Any]:
    """A map in numbers: how much is feasible, its best place, and what it took."""
    good = found.feasible == 1.0
    best: dict[str, float] = {}
    if good.any():
        sign = -1.0 if found.question.quantity == "turn" else 1.0
        k = int(np.nanargmax(np.where(good, sign * found.value, np.nan)))
        along, around = found.points[k].tolist()
        best = {"along_m": along, "around_deg": around, "value": float(found.value[k])}
    return {
        "friction": friction,
        "area": found.area,
        "best": best,
        "evaluated": found.evaluated,
        "grid": found.grid,
        "tolerance": found.tolerance,
    }


if __name__ == "__main__":
    run_from_command_line(main, __doc__, OUT)
