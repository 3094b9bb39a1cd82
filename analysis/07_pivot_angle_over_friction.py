"""How far must a tool pivot so that a finger can leave, over the friction of the fingers?

For every built-in tool, the first finger that its gait removes leaves, at the scene's own places.
Two answers: the smallest tilt after which the others hold the tool at rest (a global search by
static verdicts), and the turn of the removal as it is planned, with its motion and its ramp of
forces. The table's friction stays; the reserve of friction is 0, so that 0.6 means 0.6.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from study_files import run_from_command_line, write_results

from pivotgait.exceptions import PivotGaitError
from pivotgait.feasibility import Question, Variants
from pivotgait.gaits.steps import plan_steps
from pivotgait.models import RelocationPhase, Scene, builtin_scenes, load_scene
from pivotgait.phases.grasp import Setting
from pivotgait.plotting import save_figure
from pivotgait.plotting.curves import Curve, Panel, curve_panels

OUT = Path("reports/out/analysis/07")
FRICTION = (0.3, 1.2)
TURN_LABEL = "turn [deg]"


def main(quick: bool = False, out: Path = OUT) -> dict[str, Any]:
    """Run the study; write ``turn_over_friction`` as PDF and PNG, and ``turns.json``.

    Args:
        quick: two tools and three frictions instead of all and 19.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, friction = Console(), np.linspace(*FRICTION, 3 if quick else 19)
    tools = [answer(load_scene(name), friction) for name in scenes()[: 2 if quick else None]]
    panels = []
    for each in tools:
        least, planned = np.array(each["least_deg"]), np.array(each["planned_deg"])
        curves = (
            Curve("smallest tilt that the others hold", friction, least),
            Curve("planned removal", friction, planned, style="", marker="o"),
        )
        title = f"{each['scene']}: {each['finger']} leaves"
        label = "friction of the fingers $\\mu_H$ [-]"
        above = title.replace(": ", "\n")
        panels.append(Panel(above, label, TURN_LABEL, curves, y_range=(-1.0, None)))
        excess = planned - least
        console.print(
            f"{title}: {np.nanmin(least):.1f} to {np.nanmax(least):.1f} deg; planned removals "
            f"turn {np.nanmedian(excess):.2f} deg more (median), "
            f"{int(np.isnan(planned).sum())} of {len(friction)} without a plan"
        )
    save_figure(curve_panels([panels]), out, "turn_over_friction")
    result = {"friction": friction.tolist(), "tools": tools}
    write_results(out / "turns.json", result)
    return result


def scenes() -> list[str]:
    """The built-in scenes, one for each tool."""
    tools: dict[str, str] = {}
    for name in sorted(builtin_scenes(), key=len):
        tools.setdefault(load_scene(name).tool.name, name)
    return sorted(tools.values())


def answer(scene: Scene, friction: Any) -> dict[str, Any]:
    """Smallest and planned turns of a scene's first removal at each friction; NaN without one."""
    variants, question = Variants(scene), Question.about(scene, quantity="turn")
    changes = [
        {"contacts.*.friction": mu, "allocation.friction_reserve": 0.0} for mu in friction.tolist()
    ]
    varied = [variants.scene_with(each) for each in changes]
    config = scene.gaits[question.gait][question.place]
    return {
        "scene": scene.name,
        "finger": scene.contacts[getattr(config, "contact")].finger,  # noqa: B009
        "least_deg": question.answers(varied).value.tolist(),
        "planned_deg": [planned_turn(each, question) for each in varied],
    }


def planned_turn(scene: Scene, question: Question) -> float:
    """Turn of the planned removal [deg], after the phases that lead to it; NaN without a plan."""
    gait = scene.gaits[question.gait][: question.place + 1]
    try:
        steps = plan_steps(
            Setting.of(scene), [each for each in gait if not isinstance(each, RelocationPhase)]
        )
    except PivotGaitError:
        return float("nan")
    phase = steps[-1].phase
    return float("nan") if phase is None else float(phase.reorientation_deg)


if __name__ == "__main__":
    run_from_command_line(main, __doc__, OUT)
