"""Does a gait hang on the engine's step, or on how hard its contacts are?

The nominal run of a scene's gait at every step of the physics engine and every stiffness of its
contacts, with the same plan, controller and gains. The controller runs at 1 kHz, or once a step
where the step is longer. What passes, and how closely each run followed, stands in one table.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from study_files import write_results

from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import RunOptions, SimulatorOptions, TrialOptions, run_trials

STEPS_S = (2e-3, 1e-3, 5e-4, 2.5e-4)
STIFFNESS_N_M = (2e3, 2e4, None)
"""None: the engine's hard contacts."""
METRICS = {
    "holding_force_rms_N": "hold, N",
    "loading_force_rms_N": "load, N",
    "orientation_deg": "turn, deg",
    "tip_slip_mm": "tip, mm",
    "fingertip_slip_mm": "finger, mm",
}


def main(
    quick: bool = False,
    out: Path | None = None,
    simulator: str = "pybullet",
    workers: int | None = None,
) -> dict[str, Any]:
    """Run the grid; write ``step_and_stiffness_<simulator>.json`` into ``out``.

    Args:
        quick: the lift alone, at the shortest and the longest step.
        out: folder, made if missing; nothing is written without one.
        simulator: name of the engine.
        workers: processes at a time.

    Returns:
        What was written.
    """
    plan = plan_gait(load_scene("knife"))
    options, steps = RunOptions(simulator=simulator), STEPS_S
    if quick:
        plan = replace(plan, phases=plan.phases[:1])
        options, steps = replace(options, hold_s=0.1), (STEPS_S[0], STEPS_S[1])
    rows = [
        cell(plan, replace(options, engine=SimulatorOptions(step, stiffness)), workers)
        for stiffness in STIFFNESS_N_M
        for step in steps
    ]
    result = {
        "simulator": simulator,
        "runs": rows,
        "all_passed": all(row["passed"] for row in rows),
    }
    tell(result)
    if out is not None:
        write_results(out / f"step_and_stiffness_{simulator}.json", result)
    return result


def cell(plan: GaitPlan, options: RunOptions, workers: int | None) -> dict[str, Any]:
    """One nominal run, in a process of its own."""
    trials = run_trials(plan, [0], TrialOptions(options, perturbed=False), workers=workers)
    (run,) = trials.as_json()["runs"]
    return {
        "step_s": options.engine.step_s,
        "stiffness_N_m": options.engine.contact_stiffness,
        **{name: run[name] for name in ("passed", "failure", "stage", "detail", "metrics")},
    }


def tell(result: dict[str, Any]) -> None:
    """Print the table."""
    table = Table("step", "contacts", "verdict", *METRICS.values())
    for row in result["runs"]:
        stiffness, metrics = row["stiffness_N_m"], row["metrics"]
        table.add_row(
            f"{1e3 * row['step_s']:g} ms",
            "hard" if stiffness is None else f"{1e-3 * stiffness:g} kN/m",
            "passed" if row["passed"] else f"{row['failure']}, {row['stage']}: {row['detail']}",
            *(f"{metrics[name]:.3f}" if name in metrics else "-" for name in METRICS),
        )
    Console().print(table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis"))
    parser.add_argument("--simulator", default="pybullet")
    given = parser.parse_args()
    main(given.quick, given.out, given.simulator)
