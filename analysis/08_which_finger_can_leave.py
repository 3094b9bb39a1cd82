"""Which finger can leave at which lift angle?

Every built-in tool is held by all fingers of its gait's first addition, lifted to one pitch after
the other. Each finger in turn leaves: by how much do the others hold the tool as it stands, and
how far must it turn until they do? Friction counts without the scene's reserve, as for plans.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from study_files import run_from_command_line, write_results

from pivotgait.feasibility import Question, Variants
from pivotgait.feasibility.maps import scenes_at
from pivotgait.frozen import Array
from pivotgait.models import AdditionPhase, Scene, load_scene
from pivotgait.plans.layout import phase_name
from pivotgait.plotting import save_figure
from pivotgait.plotting.curves import Curve, Panel, curve_panels

OUT = Path("reports/out/analysis/08")
PITCH_DEG = (5.0, 65.0)
LEAST_ROOM_N, MOST_ROOM_N = -0.6, 0.4
"""Of the vertical axis: how far from holding, beyond some newtons, tells nothing."""


def main(quick: bool = False, out: Path = OUT) -> dict[str, Any]:
    """Run the study; write ``leaving_over_pitch`` as PDF and PNG, and ``leaving.json``.

    Args:
        quick: two tools and four pitches instead of all and 41.
        out: folder.

    Returns:
        What the JSON file holds.
    """
    console, pitch = Console(), np.linspace(*PITCH_DEG, 4 if quick else 41)
    names = import_module("07_pivot_angle_over_friction").scenes()[: 2 if quick else None]
    tools = [leaving(load_scene(name), pitch) for name in names]
    rows: list[list[Panel]] = [[], []]
    for tool in tools:
        fingers = tool["fingers"]
        room = [Curve(f, pitch, np.array(v["room_N"])) for f, v in fingers.items()]
        turn = [Curve(f, pitch, np.array(v["turn_deg"])) for f, v in fingers.items()]
        label = "pitch of the lifted tool [deg]"
        span = (LEAST_ROOM_N, MOST_ROOM_N)
        up = "room without it [N]"
        rows[0].append(Panel(tool["scene"], label, up, tuple(room), limit=0.0, y_range=span))
        rows[1].append(Panel("", label, "turn needed [deg]", tuple(turn), y_range=(-2.0, 62.0)))
        for finger, found in fingers.items():
            console.print(f"{tool['scene']}: {finger} may leave at rest {found['at_rest']}")
    save_figure(curve_panels(rows, height=1.8), out, "leaving_over_pitch")
    result = {"pitch_deg": pitch.tolist(), "tools": tools}
    write_results(out / "leaving.json", result)
    return result


def leaving(scene: Scene, pitch: Array) -> dict[str, Any]:
    """Room [N] and turns [deg] without each finger at each pitch; NaN where there is no lift."""
    gait = next(iter(scene.gaits))
    place, config = next(
        (k, c) for k, c in enumerate(scene.gaits[gait]) if isinstance(c, AdditionPhase)
    )
    phase = phase_name(place, config.kind)
    every = Question.about(scene, gait=gait, phase=phase)
    scenes, found = scenes_at(Variants(scene), [{"tool.pitch_deg": p} for p in pitch.tolist()])
    fingers = {}
    for finger in (each.finger for each in every.fingers(scene)):
        values = {}
        for quantity in ("depth", "turn"):
            asked = Question.about(scene, gait=gait, phase=phase, quantity=quantity, removed=finger)
            values[quantity] = np.full(len(pitch), np.nan)
            values[quantity][found] = asked.answers(scenes).value
        fingers[finger] = {
            "room_N": values["depth"].tolist(),
            "turn_deg": values["turn"].tolist(),
            "at_rest": spans(pitch, values["depth"] >= 0.0),
        }
    return {"scene": scene.name, "fingers": fingers}


def spans(pitch: Array, holds: Any) -> str:
    """Ranges of pitches in which a flag holds, in words."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], holds.astype(int), [0]))))
    ranges = [
        f"{pitch[a]:g} to {pitch[b - 1]:g} deg"
        for a, b in zip(edges[::2], edges[1::2], strict=True)
    ]
    return ", ".join(ranges) or "nowhere"


if __name__ == "__main__":
    run_from_command_line(main, __doc__, OUT)
