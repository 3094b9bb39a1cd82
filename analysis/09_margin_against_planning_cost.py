"""What does a larger margin of friction cost?

The first removal of every built-in tool's gait is planned with more and more friction held in
reserve, from none to the most for which there is a plan. The reserve is a bound that every force
of the plan keeps, so the plan's smallest friction margin is at least as large. It costs turning
(and acceleration) of the tool, worse aligned forces, and time to plan.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from study_files import run_from_command_line, write_results

from pivotgait.exceptions import PivotGaitError
from pivotgait.feasibility import Question, Variants
from pivotgait.frozen import Array
from pivotgait.gaits.steps import plan_steps
from pivotgait.margins import phase_margins, smallest_of_phase
from pivotgait.models import RelocationPhase, Scene, load_scene
from pivotgait.phases.grasp import Setting
from pivotgait.plotting import save_figure
from pivotgait.plotting.curves import Curve, Panel, curve_panels

OUT = Path("reports/out/analysis/09")
RESERVE = (0.0, 0.75)
PANELS = {
    "reorientation_deg": "turn [deg]",
    "alignment_deg": "mean angle of\nforce to normal [deg]",
    "plan_time_ms": "time to plan\nthe removal [ms]",
}


def main(quick: bool = False, out: Path = OUT) -> dict[str, Any]:
    """Run the study; write ``cost_over_margin`` as PDF and PNG, and ``costs.json``.

    Args:
        quick: two tools and three reserves instead of all and 26.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, reserve = Console(), np.linspace(*RESERVE, 3 if quick else 26)
    names = import_module("07_pivot_angle_over_friction").scenes()[: 2 if quick else None]
    tools = {}
    for scene in map(load_scene, names):
        planned(scene, 0.0)  # builds the solvers, which is no cost of the margin
        tools[scene.name] = [planned(scene, each) for each in reserve.tolist()]
    rows = []
    for key, label in PANELS.items():
        curves = []
        for name, cells in tools.items():
            margin, cost = (np.array([cell[k] for cell in cells]) for k in ("margin", key))
            curves.append(Curve(name, margin, cost, marker="o"))
        across = "smallest friction margin of the plan [-]"
        rows.append([Panel("", across, label, tuple(curves))])
    save_figure(curve_panels(rows, height=1.5), out, "cost_over_margin")
    summary = {name: slope(cells) for name, cells in tools.items()}
    for name, each in summary.items():
        console.print(
            f"{name}: plans up to a margin of {each['largest_margin']:.2f}; there the tool turns "
            f"{each['turn_deg'][1]:.1f} deg, with the least margin {each['turn_deg'][0]:.1f} deg; "
            f"time to plan {each['plan_time_ms'][0]:.0f} to {each['plan_time_ms'][1]:.0f} ms"
        )
    result = {"reserve": reserve.tolist(), "tools": tools, "summary": summary}
    write_results(out / "costs.json", result)
    return result


def planned(scene: Scene, reserve: float) -> dict[str, float]:
    """The first removal with a friction reserve: its margin and costs, NaN without a plan."""
    question = Question.about(scene)
    varied = Variants(scene).scene_with({"allocation.friction_reserve": reserve})
    gait = [
        each
        for each in varied.gaits[question.gait][: question.place + 1]
        if not isinstance(each, RelocationPhase)
    ]
    none = dict.fromkeys(("margin", "cost", *PANELS), float("nan")) | {"reserve": reserve}
    try:
        last = plan_steps(Setting.of(varied), gait)[-1]
    except PivotGaitError:
        return none
    phase = last.phase
    least = None if phase is None else smallest_of_phase(phase_margins(phase), ("friction",))
    if phase is None or least is None:
        return none
    return {
        "reserve": reserve,
        "margin": float(least.value),
        "cost": float(phase.record["cost"]),  # type: ignore[arg-type]
        "reorientation_deg": float(phase.reorientation_deg),
        "alignment_deg": alignment_deg(phase),
        "plan_time_ms": 1e3 * last.plan_time_s,
    }


def alignment_deg(phase: Any) -> float:
    """Mean angle between contact forces and normals over a phase and its fingers [deg]."""
    angles = []
    for track in phase.contacts.values():
        size = np.linalg.norm(track.force, axis=1)
        along = np.sum(track.force * track.world_normal(phase.tool), axis=1)
        pressing = size > 1e-3
        angles.append(np.degrees(np.arccos(np.clip(along[pressing] / size[pressing], -1, 1))))
    together: Array = np.concatenate(angles)
    return float(together.mean())


def slope(cells: list[dict[str, float]]) -> dict[str, Any]:
    """The first and the last plan there is."""
    known = [cell for cell in cells if np.isfinite(cell["margin"])]
    if not known:
        nothing = (float("nan"), float("nan"))
        return {"largest_margin": float("nan"), "turn_deg": nothing, "plan_time_ms": nothing}
    ends = (known[0], known[-1])
    return {
        "largest_margin": known[-1]["margin"],
        "turn_deg": tuple(each["reorientation_deg"] for each in ends),
        "plan_time_ms": tuple(each["plan_time_ms"] for each in ends),
    }


if __name__ == "__main__":
    run_from_command_line(main, __doc__, OUT)
