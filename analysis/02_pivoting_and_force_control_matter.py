"""What are pivoting and force control worth when the handle is not as thick as planned?

The knife's gait is carried out in a physics engine in five ways, over errors of the handle's
width and of all friction coefficients that neither planner nor controller knows:

* the **hybrid** law;
* the same with planned forces fed forward but no force control (**feed-forward**);
* **admittance** control of a position-commanded robot;
* a stiff **position** servo on the planned joint motion;
* the hybrid law **without pivoting**. No plan of such a removal exists within the friction that
  plans may use, so that there is nothing to compare but what a hand would do that does not pivot:
  tool and hand keep the posture of the removal's start; the removed finger's normal force goes to
  zero as planned; the other forces balance gravity and are the least violating ones, those that
  minimise the largest |f_t| / (mu f_n). How large that is stands beside the planned removal's.
  The gait ends with the removal, since what follows starts from the pivoted tool: passing is
  easier than for the other ways, which also relocate and add the finger.

Beside the maps stand the normal forces while the middle finger is added, as in Fig. 8 of Xue et
al., with the handle as planned and half a millimetre thicker.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rich.table import Table
from study_files import write_results

from pivotgait.gaits import plan_gait
from pivotgait.models import Scene, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.plotting.control_study import (
    OutcomeMap,
    PressingFingers,
    outcome_maps,
    pressing_fingers,
)
from pivotgait.plotting.save import save_figure
from pivotgait.validation import (
    BASELINES,
    Baseline,
    Perturbation,
    RunOptions,
    RunSeries,
    judge,
    run,
)
from pivotgait.validation.metrics import measure, normal_forces
from pivotgait.validation.planned import planned_at
from pivotgait.validation.without_pivoting import friction_share, without_pivoting

Array = NDArray[np.float64]
WIDTH_M = (-1e-3, -5e-4, 0.0, 5e-4, 1e-3)
FRICTION = (0.6, 0.8, 1.0, 1.2)
SHOWN_WIDTH_M = (0.0, 5e-4)
"""Of the pictures as in Fig. 8."""
BESIDE_S = 0.4
"""Shown before and after the addition."""


@dataclass(frozen=True)
class Cell:
    """One run.

    Attributes:
        way: name of the baseline.
        width_m: error of the handle's width.
        friction: true over planned coefficient, of fingertips and table.
        failure: class, empty where the run passed.
        stage: in which it failed.
        detail: of the failure.
        metrics: of the run.
    """

    way: str
    width_m: float
    friction: float
    failure: str
    stage: str
    detail: str
    metrics: dict[str, float]

    @property
    def force_rms_N(self) -> float:
        """Larger RMS error of holding and of loading fingers."""
        return max(self.metrics["holding_force_rms_N"], self.metrics["loading_force_rms_N"])


class Study:
    """The scene and its plan, in both forms.

    Args:
        phases: how many of the plan's phases are carried out; all without it.
        hold_s: of the final hold.

    Attributes:
        shares: of the friction that the removal needs, largest |f_t| / (mu f_n): as planned,
            without pivoting, and what plans may use.
    """

    def __init__(self, phases: int | None = None, hold_s: float = 2.0) -> None:
        self.scene: Scene = load_scene("knife")
        whole = plan_gait(self.scene)
        self.still = without_pivoting(whole, self.scene)
        removal = len(self.still.phases) - 1
        self.shares = {
            "pivoting": float(friction_share(whole.phases[removal]).max()),
            "without": float(friction_share(self.still.phases[removal]).max()),
            "usable": 1.0 - self.scene.allocation.friction_reserve,
        }
        self.plan = replace(whole, phases=whole.phases[:phases])
        self.hold_s = hold_s

    def of(self, way: Baseline) -> GaitPlan:
        """What is carried out that way."""
        return self.plan if way.pivoting else self.still

    def carry_out(self, way: Baseline, width: float, friction: float) -> tuple[Cell, RunSeries]:
        """One run in a world with these errors; the sensors are perfect."""
        robot, plan = self.scene.robot, self.of(way)
        assert robot is not None
        world = replace(
            Perturbation.none(robot),
            handle_growth=width,
            finger_friction_scale=friction,
            table_friction_scale=friction,
        )
        options = RunOptions(controller=way.controller, hold_s=self.hold_s)
        series, _ = run(plan, self.scene, world, options)
        planned = planned_at(plan, series.time, series.fingers)
        verdict = judge(plan, robot, series, planned)
        metrics = measure(robot, series, planned).as_json()
        end = (verdict.failure, verdict.stage, verdict.detail)
        return Cell(way.name, width, friction, *end, metrics), series

    def pressing(self, way: Baseline, width: float, series: RunSeries) -> PressingFingers:
        """The run while the middle finger is added."""
        place = next(k for k, each in enumerate(self.plan.phases) if each.kind == "addition")
        begin = sum(each.duration_s for each in self.plan.phases[:place])
        end = begin + self.plan.phases[place].duration_s
        chosen = (series.time >= begin - BESIDE_S) & (series.time <= end + BESIDE_S)
        planned = planned_at(self.plan, series.time, series.fingers)
        true, wanted = normal_forces(series, planned)[chosen], planned.normal_force[chosen]
        columns = list(enumerate(series.fingers))
        return PressingFingers(
            title=f"{way.name}, {1e3 * width:+g} mm" if width else way.name,
            time_s=series.time[chosen] - begin,
            planned_N={name: wanted[:, k] for k, name in columns},
            measured_N={name: true[:, k] for k, name in columns},
        )


def main(quick: bool = False, out: Path | None = None) -> dict[str, Any]:
    """Carry the gait out over the grid; write a JSON file and two figures into ``out``.

    Args:
        quick: two ways, the handle as planned and 0.5 mm thicker, up to the addition.
        out: folder, made if missing; nothing is written without one.

    Returns:
        The runs, what they come to for each way, and the friction that the removals need.
    """
    study = Study(phases=3, hold_s=0.1) if quick else Study()
    ways: Sequence[Baseline] = (BASELINES[0], BASELINES[3]) if quick else BASELINES
    widths, frictions = (SHOWN_WIDTH_M, (1.0,)) if quick else (WIDTH_M, FRICTION)
    cells: list[Cell] = []
    shown: dict[tuple[str, float], PressingFingers] = {}
    grid = [(way, width, mu) for way in ways for mu in frictions for width in widths]
    for way, width, friction in track(grid, "runs", transient=True):
        cell, series = study.carry_out(way, width, friction)
        cells.append(cell)
        if way.pivoting and friction == 1.0 and width in SHOWN_WIDTH_M:
            shown[way.name, width] = study.pressing(way, width, series)
    result = {
        "friction_share": study.shares,
        "cells": [asdict(cell) for cell in cells],
        "summary": summary(cells),
    }
    tell(result)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        maps = [picture(way.name, cells, widths, frictions) for way in ways]
        rows = [[shown[way.name, w] for way in ways if way.pivoting] for w in SHOWN_WIDTH_M]
        save_figure(outcome_maps(maps), out, "control_outcomes")
        save_figure(pressing_fingers(rows), out, "control_added_finger")
        write_results(out / "control.json", result)
    return result


def summary(cells: Sequence[Cell]) -> dict[str, dict[str, Any]]:
    """For each way: runs that passed, largest force error of those, what the others failed by."""
    found = {}
    for way in dict.fromkeys(cell.way for cell in cells):
        mine = [cell for cell in cells if cell.way == way]
        passed = [cell for cell in mine if not cell.failure]
        failures = [f"{cell.failure} in {cell.stage}" for cell in mine if cell.failure]
        found[way] = {
            "runs": len(mine),
            "passed": len(passed),
            "force_rms_N": max((cell.force_rms_N for cell in passed), default=None),
            "failures": {each: failures.count(each) for each in dict.fromkeys(failures)},
            "widths_passed_mm": sorted({1e3 * cell.width_m for cell in passed}),
        }
    return found


def picture(
    way: str, cells: Sequence[Cell], widths: Sequence[float], frictions: Sequence[float]
) -> OutcomeMap:
    """The map of one way."""
    found = {(cell.width_m, cell.friction): cell for cell in cells if cell.way == way}
    rows = [[found[width, friction] for width in widths] for friction in frictions]
    return OutcomeMap(
        title=way.replace(", ", ",\n"),
        width_mm=1e3 * np.array(widths),
        friction=np.array(frictions),
        failure=[[cell.failure for cell in row] for row in rows],
        force_rms_N=np.array([[cell.force_rms_N for cell in row] for row in rows]),
    )


def tell(result: dict[str, Any]) -> None:
    """Print what each way comes to."""
    table = Table("way", "passed", "largest force RMS of these", "failures of the others")
    for way, found in result["summary"].items():
        force = found["force_rms_N"]
        table.add_row(
            way,
            f"{found['passed']} of {found['runs']}",
            "-" if force is None else f"{force:.2f} N",
            ", ".join(f"{count} {name}" for name, count in found["failures"].items()),
        )
    console, shares = Console(), result["friction_share"]
    console.print(table)
    console.print(
        f"share of the friction that the removal needs: {shares['pivoting']:.2f} as planned, "
        f"{shares['without']:.2f} without pivoting; plans may use {shares['usable']:.2f}"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="four runs, up to the addition")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis/02"))
    given = parser.parse_args()
    main(given.quick, given.out)
