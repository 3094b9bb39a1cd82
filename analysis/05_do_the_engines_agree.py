"""Do two physics engines say the same of a gait, and which conclusions hang on how they compute?

The knife's plan is carried out without perturbation in PyBullet and in MuJoCo while one thing at a
time is changed in both: the step, the shape of the friction cone, the stiffness of contacts, the
true friction, the iterations of the contact solver, the controller. Of each run it is asked
whether a conclusion holds: the gait is carried out, and errors of forces and of the orientation
and the slips stay within what a nominal run is meant to keep. A conclusion *holds in both* under a
setting if both engines say so; it *hangs on the engine* where they say different things.

* **Cone.** An elliptic cone is Coulomb's. MuJoCo's pyramid lies within it, so that friction along
  its diagonals is 29 % lower; PyBullet's lies about it, so that it is 41 % higher. MuJoCo's
  pyramidal contacts are also about a thousand times stiffer than asked for (it divides their
  normal softness by the impedance ratio of friction, 100 here), so that its row changes two things
  at once. With the ratio of 1e4 that the elliptic cone has, they throw the tool during the lift.
* **Step.** The controller's period is 1 ms, or the step where that is longer: a step of 2 ms slows
  the controller down, too.
* **Friction.** The true coefficients of fingertips and table are scaled together; the plan keeps
  believing in its own.
* **Hard contacts** are each engine's own: PyBullet's default, MuJoCo's shortest time constant.

Beside it the paper's Fig. 4: the force of the removed finger in its friction cone and the angles
of all forces to their normals, in the plan and in each engine. The paper shows its own from MuJoCo.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table
from study_files import write_results

from pivotgait.gaits import plan_gait
from pivotgait.models import Scene, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.plotting.engine_study import conclusions_grid, removal_in_engines
from pivotgait.plotting.save import save_figure
from pivotgait.reporting.run_rows import AIMS
from pivotgait.validation import (
    CarriedOut,
    Metrics,
    Perturbation,
    RunOptions,
    SimulatorOptions,
    Verdict,
    compare_runs,
    judge,
    run,
)
from pivotgait.validation.metrics import measure
from pivotgait.validation.planned import planned_at
from pivotgait.validation.record_reading import RecordedMotion
from pivotgait.validation.series import RunSeries
from pivotgait.validation.simulator import check_simulator

SCENE = "knife"
ENGINES = ("pybullet", "mujoco")
CONCLUSIONS = {
    "carried\nout": None,
    "holding\nforce": "holding_force_rms_N",
    "loading\nforce": "loading_force_rms_N",
    "orien-\ntation": "orientation_deg",
    "tip\nslip": "tip_slip_mm",
    "fingertip\nslip": "fingertip_slip_mm",
    "torques": "torque_share",
}
"""Column of the figure -> the metric that must stay within its aim; None for the verdict."""


@dataclass(frozen=True)
class Setting:
    """One row of the study.

    Attributes:
        name: of what was changed.
        engine: options of both simulators.
        friction: scale of the true coefficients.
        controller: name of the control law.
    """

    name: str
    engine: SimulatorOptions = field(default_factory=SimulatorOptions)
    friction: float = 1.0
    controller: str = "hybrid"


def settings(quick: bool) -> tuple[Setting, ...]:
    """As chosen first, then one change at a time."""
    usual = SimulatorOptions()

    def engine(name: str, **changes: Any) -> Setting:
        return Setting(name, replace(usual, **changes))

    few = (
        Setting("as chosen"),
        engine("pyramidal cone", friction_cone="pyramidal"),
        engine("2 kN/m", contact_stiffness=2e3),
    )
    if quick:
        return few
    return (
        *few,
        engine("hard contacts", contact_stiffness=None),
        engine("step 0.5 ms", step_s=5e-4),
        engine("step 2 ms", step_s=2e-3),
        engine("10 iterations", solver_iterations=10),
        engine("200 iterations", solver_iterations=200),
        Setting("friction × 0.8", friction=0.8),
        Setting("friction × 0.6", friction=0.6),
        Setting("friction × 1.2", friction=1.2),
        Setting("position control", controller="position"),
    )


@dataclass(frozen=True, eq=False)
class Ran:
    """One run of one setting in one engine."""

    series: RunSeries
    verdict: Verdict
    metrics: Metrics

    def holds(self, metric: str | None) -> bool:
        """Whether a conclusion holds: the verdict, or a metric within its aim.

        What a run that failed measured says nothing of the phases it did not come to.
        """
        if metric is None or not self.verdict.passed:
            return self.verdict.passed
        return bool(getattr(self.metrics, metric) <= AIMS[metric])

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"verdict": vars(self.verdict).copy(), "metrics": self.metrics.as_json()}


def carry_out(plan: GaitPlan, scene: Scene, setting: Setting, engine: str) -> Ran:
    """The nominal run of a setting."""
    assert scene.robot is not None
    nominal = Perturbation.none(scene.robot)
    perturbation = replace(
        nominal,
        finger_friction_scale=setting.friction,
        table_friction_scale=setting.friction,
    )
    options = RunOptions(simulator=engine, controller=setting.controller, engine=setting.engine)
    series, _ = run(plan, scene, perturbation, options)
    planned = planned_at(plan, series.time, series.fingers)
    return Ran(
        series, judge(plan, scene.robot, series, planned), measure(scene.robot, series, planned)
    )


def main(quick: bool = False, out: Path = Path("reports/out/analysis/05")) -> dict[str, Any]:
    """Run the study, print its table, write figures and ``engines.json``; returns the latter.

    Quick: the gait up to its first removal, three settings.
    """
    console, began = Console(), perf_counter()
    for engine in ENGINES:
        check_simulator(engine)
    scene = load_scene(SCENE)
    plan = plan_gait(scene)
    removal = next(phase.name for phase in plan.phases if phase.kind == "removal")
    if quick:
        plan = up_to(plan, removal)
    chosen = settings(quick)
    runs: dict[str, dict[str, Ran]] = {}
    for setting in track(chosen, console=console, description="settings"):
        runs[setting.name] = {each: carry_out(plan, scene, setting, each) for each in ENGINES}
    result = {
        "scene": SCENE,
        "engines": list(ENGINES),
        "aims": dict(AIMS),
        "settings": {name: summary(plan, scene, pair) for name, pair in runs.items()},
        "conclusions": conclusions(runs),
    }
    out.mkdir(parents=True, exist_ok=True)
    draw(plan, scene, removal, runs, out)
    target = out / "engines.json"
    write_results(target, result)
    tell(console, result)
    console.print(f"{out}: {perf_counter() - began:.0f} s")
    return result


def up_to(plan: GaitPlan, name: str) -> GaitPlan:
    """The plan's phases up to the one called ``name``, which is kept."""
    names = [phase.name for phase in plan.phases]
    return replace(plan, phases=plan.phases[: names.index(name) + 1])


def summary(plan: GaitPlan, scene: Scene, pair: Mapping[str, Ran]) -> dict[str, Any]:
    """One setting in both engines: figures of each run, and how far they agree."""
    assert scene.robot is not None
    one, two = (CarriedOut(name, each.series, each.verdict) for name, each in pair.items())
    agreement = compare_runs(plan, scene.robot, one, two).as_json()
    kept = ("same_verdict", "agrees", "share_within", "largest_gap")
    runs = {name: each.as_json() for name, each in pair.items()}
    return {"runs": runs, "agreement": {key: agreement[key] for key in kept}}


def conclusions(runs: Mapping[str, Mapping[str, Ran]]) -> dict[str, Any]:
    """Of each conclusion the settings under which it holds in both, in neither, in one engine."""
    found: dict[str, Any] = {}
    for title, metric in CONCLUSIONS.items():
        said = {name: [pair[each].holds(metric) for each in ENGINES] for name, pair in runs.items()}
        found[" ".join(title.replace("-\n", "").split())] = {
            "both": [name for name, each in said.items() if all(each)],
            "neither": [name for name, each in said.items() if not any(each)],
            "one_only": {
                name: ENGINES[each.index(True)]
                for name, each in said.items()
                if any(each) and not all(each)
            },
        }
    return found


def draw(
    plan: GaitPlan,
    scene: Scene,
    removal: str,
    runs: Mapping[str, Mapping[str, Ran]],
    out: Path,
) -> None:
    """Write the figures."""
    assert scene.robot is not None
    holds = {
        engine: np.array(
            [[float(pair[engine].holds(m)) for m in CONCLUSIONS.values()] for pair in runs.values()]
        )
        for engine in ENGINES
    }
    save_figure(conclusions_grid(list(runs), list(CONCLUSIONS), holds), out, "conclusions")
    usual = next(iter(runs.values()))
    motions = {
        name: RecordedMotion.of(plan, scene.robot, each.series) for name, each in usual.items()
    }
    save_figure(removal_in_engines(plan, removal, motions), out, "removal")


def tell(console: Console, result: Mapping[str, Any]) -> None:
    """Print the table and the conclusions that hang on the engine or on a setting."""
    console.print(filled(result["settings"]))
    for name, said in result["conclusions"].items():
        one = [f"{setting} ({engine})" for setting, engine in said["one_only"].items()]
        console.print(
            f"{name}: in both engines under {len(said['both'])} of {len(result['settings'])} "
            f"settings; in neither: {listed(said['neither'])}; in one only: {listed(one)}"
        )


def filled(rows: Mapping[str, Any]) -> Table:
    """Figures of both engines, PyBullet's first."""
    table = Table(title=f"{' / '.join(ENGINES)}: nominal runs of the {SCENE}")
    table.add_column("setting")
    heads = ("verdict", "hold N", "load N", "turn deg", "tip mm", "finger mm", "within", "gap")
    for head in heads:
        table.add_column(head, justify="right")
    for name, row in rows.items():
        runs = list(row["runs"].values())
        words = [r["verdict"]["failure"] or "passed" for r in runs]
        cells = [" / ".join(f"{r['metrics'][key]:.2f}" for r in runs) for key in list(AIMS)[:5]]
        gap = row["agreement"]["largest_gap"]["ratio"]
        share = f"{100 * row['agreement']['share_within']:.0f} %"
        table.add_row(name, "\n".join(words), *cells, share, "-" if gap is None else f"{gap:.1f}")
    return table


def listed(names: Sequence[str]) -> str:
    """Names as text."""
    return ", ".join(names) or "none"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="up to the removal, three settings")
    parser.add_argument("--out", type=Path, default=Path("reports/out/analysis/05"))
    given = parser.parse_args()
    main(given.quick, given.out)
