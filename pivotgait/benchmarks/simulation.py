"""How fast each physics engine carries a gait out, and its share of the closed loop."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pivotgait.exceptions import InputError
from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.validation import Perturbation, RunOptions, run
from pivotgait.validation.simulator import SIMULATORS, check_simulator


def simulation_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Mean cycle of 1 ms under the hybrid law: ours is the closed loop, the peer the engine.

    The knife's whole gait, or its lift if quick, after the fingers have closed. The real-time
    factor is simulated over spent time, of the closed loop and of the engine alone.
    """
    scene = load_scene("knife")
    assert scene.robot is not None
    plan, nominal = plan_gait(scene), Perturbation.none(scene.robot)
    if quick:
        plan = replace(plan, phases=plan.phases[:1])
    rows = []
    for name in SIMULATORS:
        label = f"control cycle of {1e3 * RunOptions().cycle_s:g} ms, simulated in {name}"
        try:
            check_simulator(name)
        except InputError as error:
            rows.append(_row(f"{label} ({error})"))
            continue
        options = RunOptions(simulator=name)
        timing = run(plan, scene, nominal, options)[1]
        spent = timing.control_s + timing.simulator_s
        factor, alone = options.cycle_s / spent, options.cycle_s / timing.simulator_s
        row = _row(f"{label}: {factor:.1f} x real time, {alone:.1f} x the engine alone")
        row |= {
            "ours_s": spent,
            "peer": f"{name}: step and contacts",
            "peer_s": timing.simulator_s,
            "ratio": timing.simulator_s / spent,
            "real_time_factor": factor,
            "engine_real_time_factor": alone,
        }
        rows.append(row)
    return rows


def _row(name: str) -> dict[str, Any]:
    return {"name": name, "ours_s": None, "peer": None, "peer_s": None, "ratio": None}
