"""Do errors pile up when fingers walk, and does planning anew from measurements keep them small?

Six gaits in a row on the knife's handle: index and middle finger step in turn while the thumb
stays. Each run is made twice: with the plan as it was, and with the rest of it planned anew after
each addition from the measured joints, tool and contacts (``pivotgait validate --replan``). At the
end of each gait stands how far the tip has slid along the table, how far the tool is turned from
what was asked at that moment (and from the first plan: a removal planned anew may end in another
orientation, which is no error), and how far a finger has slid at most since it arrived. One nominal
run, and perturbed ones with the tool lying as planned.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation
from study_files import run_from_command_line, write_results

from pivotgait.frozen import Array
from pivotgait.gaits import plan_gait
from pivotgait.models import Robot, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.plotting.save import save_figure
from pivotgait.plotting.walk_drift import Walk, walk_drift
from pivotgait.validation import ReplanOptions, TrialOptions, TrialResult, run_trials
from pivotgait.validation.planned import Planned
from pivotgait.validation.slips import fingertip_slips, tip_slip

SEEDS = range(9000, 9010)
_LAST = ("tip_mm", "turn_deg", "turn_from_first_deg")
KINDS = {False: "as planned", True: "planned anew"}


def main(
    quick: bool = False, out: Path | None = None, workers: int | None = None
) -> dict[str, Any]:
    """Run all walks; write ``walking.json`` and the figure ``walking`` into ``out``.

    Args:
        quick: one gait of the knife, the nominal run alone.
        out: folder, made if missing; nothing is written without one.
        workers: processes at a time.

    Returns:
        What was written.
    """
    scene = load_scene("knife" if quick else "knife_walk")
    assert scene.robot is not None  # of both scenes
    plan, walks = plan_gait(scene), []
    for perturbed, seeds in ((False, [0]), (True, [] if quick else list(SEEDS))):
        for replans in KINDS:
            options = TrialOptions(
                perturbed=perturbed,
                plan_as_laid=False,
                replanning=ReplanOptions() if replans else None,
            )
            found = run_trials(plan, seeds, options, workers=workers).results if seeds else ()
            walks += [walk(plan, scene.robot, each, replans, perturbed) for each in found]
    result = {"scene": scene.name, "gaits": _gaits(plan), "sets": _sets(walks), "runs": walks}
    tell(result)
    if out is not None:
        write_results(out / "walking.json", result)
        save_figure(walk_drift([_drawn(each) for each in walks]), out, "walking")
    return result


def walk(
    plan: GaitPlan, robot: Robot, result: TrialResult, replans: bool, perturbed: bool
) -> dict[str, Any]:
    """One run: drift and slip at the end of each addition that it came to, and its seams."""
    run: dict[str, Any] = {
        "seed": result.seed,
        "replans": replans,
        "perturbed": perturbed,
        "passed": result.verdict.passed,
        "failure": result.verdict.failure or None,
        "stage": result.verdict.stage or None,
        "seams": [seam.as_json() for seam in result.seams],
        "tip_mm": [],
        "turn_deg": [],
        "turn_from_first_deg": [],
        "finger_mm": [],
    }
    series, planned = result.series, result.planned
    if series is None or planned is None:
        return run
    ends = addition_ends(planned)
    if not result.verdict.passed:
        ends = ends[series.time[ends] <= result.verdict.time_s]
    slips = np.max([*fingertip_slips(robot, series, planned).values()], axis=0)
    tool = Rotation.from_quat(series.tool_orientation[ends])
    asked = Rotation.from_quat(planned.orientation[ends])
    first = first_orientations(plan)[: len(ends)]
    run["tip_mm"] = (1e3 * tip_slip(series)[ends]).tolist()
    run["turn_deg"] = np.degrees((asked.inv() * tool).magnitude()).tolist()
    run["turn_from_first_deg"] = np.degrees((first.inv() * tool).magnitude()).tolist()
    run["finger_mm"] = [1e3 * float(slips[a:b].max()) for a, b in _spans(ends)]
    return run


def addition_ends(planned: Planned) -> Array:
    """Rows at which a finger that was being loaded begins to hold."""
    came = (planned.loads[:-1] > 0.0) & (planned.holds[1:] > 0.0)
    return np.flatnonzero(came.any(axis=1)) + 1


def first_orientations(plan: GaitPlan) -> Rotation:
    """The tool at the end of each addition as first planned, world <- tool."""
    ends = [each.tool.orientation[-1] for each in plan.phases if each.kind == "addition"]
    return Rotation.from_quat(np.array(ends))


def _spans(ends: Array) -> list[tuple[int, int]]:
    """From the end before to each end."""
    return list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=False))


def _gaits(plan: GaitPlan) -> int:
    return sum(phase.kind == "removal" for phase in plan.phases)


def _sets(walks: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Counts, and medians at the end of the walk, of each way of running."""
    found = []
    for perturbed in (False, True):
        for replans, name in KINDS.items():
            mine = [w for w in walks if (w["perturbed"], w["replans"]) == (perturbed, replans)]
            if not mine:
                continue
            seams = [seam for each in mine for seam in each["seams"]]
            times = [seam["plan_time_s"] for seam in seams]
            found.append(
                {
                    "way": name,
                    "perturbed": perturbed,
                    "runs": len(mine),
                    "passed": sum(each["passed"] for each in mine),
                    **{key: _median_of_last(mine, key) for key in _LAST},
                    "finger_mm": float(
                        np.median([max(w["finger_mm"], default=np.nan) for w in mine])
                    ),
                    "seams": len(seams),
                    "replanned": sum(seam["replanned"] for seam in seams),
                    "plan_time_s": float(np.median(times)) if times else None,
                    "longest_plan_time_s": max(times, default=None),
                }
            )
    return found


def _median_of_last(walks: Sequence[dict[str, Any]], key: str) -> float:
    return float(np.median([each[key][-1] if each[key] else np.nan for each in walks]))


def _drawn(run: dict[str, Any]) -> Walk:
    keys = ("tip_mm", "turn_deg", "finger_mm")
    tip, turn, finger = (np.array(run[key], dtype=float) for key in keys)
    return Walk(KINDS[run["replans"]], run["perturbed"], tip, turn, finger)


def tell(result: dict[str, Any]) -> None:
    """Print one row for each way of running."""
    table = Table(title=f"{result['gaits']} gaits in a row, {result['scene']}")
    names = ("way", "runs", "passed", "tip, mm", "turn, deg", "finger, mm", "planned anew", "s")
    for name in names:
        table.add_column(name, justify="left" if name == "way" else "right")
    for each in result["sets"]:
        seconds = each["plan_time_s"]
        table.add_row(
            f"{each['way']}, {'perturbed' if each['perturbed'] else 'nominal'}",
            str(each["runs"]),
            str(each["passed"]),
            *(f"{each[key]:.2f}" for key in ("tip_mm", "turn_deg", "finger_mm")),
            f"{each['replanned']} of {each['seams']}",
            "-" if seconds is None else f"{seconds:.1f}",
        )
    Console().print(table)


if __name__ == "__main__":
    run_from_command_line(
        main,
        __doc__,
        Path("reports/out/walking"),
        workers={"type": int, "default": None, "help": "processes at a time"},
    )
