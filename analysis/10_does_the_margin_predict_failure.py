"""How does each perturbation eat the margin, and does the margin predict failure in a simulator?

One plan is carried out in many perturbed trials. For every trial the margin of its draw is
computed from the plan alone (``trial_margins.py``), before and without the simulation; then the
two are compared: the area under the ROC curve is the chance that a trial which failed had a lower
margin than one which passed (0.5: no better than a coin). Trials for which no plan was found, or
which ran out of time, count in neither.

Hardly any trial fails with errors as the scene has them. So each trial's errors are larger by a
factor of its own, uniform between 1 and ``enlarged``; 2.5 lets 25 to 40 % fail (found on seeds
2000 to 2029). With that factor alone failures can be told to some extent: its area, and those of
single errors, stand beside the margins' areas.

Trials are kept as they come, in ``trials_<plan>.jsonl``: the same command goes on where it was
stopped, and draws the figure again from what is there. Delete them when simulator or controller
have changed.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from study_files import run_from_command_line, write_results
from trial_margins import SWEPT, PlanMargins, alone
from trial_prediction import MARGINS, NO_RUN, prediction

from pivotgait.gaits import plan_gait
from pivotgait.models import Robot, Scene, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.plotting import save_figure
from pivotgait.plotting.margin_prediction import MarginPrediction, margin_prediction
from pivotgait.validation import RunOptions, TrialOptions, TrialResult, run_trials
from pivotgait.validation.perturbation import Perturbation, size_of_errors

OUT = Path("reports/out/analysis/10")
SHARES = np.linspace(-1.0, 1.0, 9)
BATCH, KEPT = 8, ("passed", "failure", "stage", "detail")


def main(
    quick: bool = False,
    out: Path = OUT,
    scene: str = "knife",
    trials: int = 300,
    seed: int = 0,
    workers: int | None = None,
    simulator: str = "pybullet",
    controller: str = "hybrid",
    enlarged: float = 2.5,
) -> dict[str, Any]:
    """Run the study; write ``margin_and_failure`` as PDF, PNG and JSON beside the trials.

    Args:
        quick: two trials.
        out: folder.
        scene: with a robot.
        trials: number of trials.
        seed: of the first; they go on from there.
        workers: processes at a time; as many as the machine lends us by default.
        simulator: see :class:`RunOptions`.
        controller: likewise.
        enlarged: largest factor of a trial's errors, see :class:`TrialOptions`.

    Returns:
        What the JSON file holds.
    """
    console, loaded = Console(), load_scene(scene)
    plan, robot = plan_gait(loaded, seed=0), loaded.robot
    assert robot is not None, "without a hand nothing can be carried out"
    margins = PlanMargins(plan, loaded)
    run = RunOptions(simulator=simulator, controller=controller)
    options = TrialOptions(run=run, errors_up_to=enlarged)
    seeds = range(seed, seed + (2 if quick else trials))
    kept = carried_out(plan, options, seeds, out, workers, console)
    rows = [row(kept[each], loaded, robot, margins, options) for each in seeds]
    result = {
        "scene": scene,
        "simulator": simulator,
        "controller": controller,
        "enlarged": enlarged,
        "seeds": [seeds[0], seeds[-1]],
        "trials": len(rows),
        "failures": dict(Counter(each["failure"] for each in rows if not each["passed"])),
        "nominal_margin": margins.by_phase(Perturbation.none(robot)),
        "eaten": eaten(robot, margins),
        "prediction": prediction(rows),
        "rows": rows,
    }
    save_figure(margin_prediction(drawn(result)), out, f"margin_and_failure_{scene}")
    write_results(out / f"margin_and_failure_{scene}.json", result)
    tell(result, console)
    return result


def carried_out(
    plan: GaitPlan,
    options: TrialOptions,
    seeds: range,
    out: Path,
    workers: int | None,
    console: Console,
) -> dict[int, dict[str, Any]]:
    """Every trial's verdict by its seed: those that are kept already, and the missing ones."""
    named = f"{plan.scene}{plan.seed}{options}".encode()
    file = out / f"trials_{hashlib.sha256(named).hexdigest()[:10]}.jsonl"
    out.mkdir(parents=True, exist_ok=True)
    kept = read_kept(file)
    missing = [each for each in seeds if each not in kept]
    # written anew: a line that a kill cut short must not join the next one
    with file.open("w", encoding="utf-8") as sink:
        sink.writelines(json.dumps(each) + "\n" for each in kept.values())

        def keep(result: TrialResult) -> None:
            verdict = result.verdict
            found = {name: getattr(verdict, name) for name in KEPT} | {"seed": result.seed}
            sink.write(json.dumps(found) + "\n")
            sink.flush()
            kept[result.seed] = found

        batches = [missing[k : k + BATCH] for k in range(0, len(missing), BATCH)]
        for batch in track(batches, "trials", console=console, transient=True):
            run_trials(plan, batch, options, workers=workers, progress=keep)
    return kept


def read_kept(file: Path) -> dict[int, dict[str, Any]]:
    """Trials of an earlier run by their seed, without a line that a kill cut short."""
    kept = {}
    for line in file.read_text().splitlines() if file.exists() else []:
        with suppress(ValueError):
            found = json.loads(line)
            kept[found["seed"]] = found
    return kept


def row(
    found: dict[str, Any], scene: Scene, robot: Robot, margins: PlanMargins, options: TrialOptions
) -> dict[str, Any]:
    """A trial's verdict beside its draw and the margins that the draw leaves."""
    draw = options.perturbation(scene, robot, found["seed"])
    gains = np.array(list(draw.sensing.gain.values()))
    angles = [np.degrees(np.arccos((np.trace(t) - 1.0) / 2.0)) for t in draw.sensing.turn.values()]
    return {
        **found,
        "margin": margins.margin(draw),
        "held_margin": margins.margin(draw, held=True),
        "sensed_margin_N": margins.sensed_margin(draw),
        "mass_scale": draw.mass_scale,
        "finger_friction_scale": draw.finger_friction_scale,
        "table_friction_scale": draw.table_friction_scale,
        "offset_m": float(np.hypot(*draw.offset[:2])),
        "sensing_gain_error": float(np.abs(gains - 1.0).max()),
        "sensing_angle_deg": float(max(angles)),
        "errors_size": size_of_errors(found["seed"], options.errors_up_to),
    }


def eaten(robot: Robot, margins: PlanMargins) -> dict[str, list[float]]:
    """The margin under each perturbation alone, over shares of its half width."""
    return {
        name: [margins.margin(alone(robot, name, share)) for share in SHARES.tolist()]
        for name in SWEPT
    }


def drawn(result: dict[str, Any]) -> MarginPrediction:
    """What the figure shows."""
    run = [each for each in result["rows"] if each["failure"] not in NO_RUN]
    found = result["prediction"]
    return MarginPrediction(
        shares=SHARES,
        eaten={name: np.array(values) for name, values in result["eaten"].items()},
        margin=np.array([each["sensed_margin_N"] for each in run]),
        passed=np.array([float(each["passed"]) for each in run]),
        curves={
            name: (np.array(found[name]["false"]), np.array(found[name]["true"]))
            for name in MARGINS
        },
        area={name: found[name]["area"] for name in MARGINS},
    )


def tell(result: dict[str, Any], console: Console) -> None:
    """Print the answer."""
    passed = sum(each["passed"] for each in result["rows"])
    console.print(f"{passed} of {result['trials']} trials passed; failures: {result['failures']}")
    for name, each in result["prediction"].items():
        low, high = each["interval_95"]
        sure = f"95 %: {low:.3f} to {high:.3f}; p = {each['p_value']:.1g}"
        console.print(f"ROC area of {name}: {each['area']:.3f} ({sure})")


if __name__ == "__main__":
    run_from_command_line(
        main,
        __doc__,
        OUT,
        scene={"default": "knife"},
        trials={"type": int, "default": 300},
        seed={"type": int, "default": 0},
        workers={"type": int, "default": None},
        simulator={"default": "pybullet"},
        controller={"default": "hybrid"},
        enlarged={"type": float, "default": 2.5},
    )
