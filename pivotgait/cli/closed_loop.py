"""Commands that carry a plan out: ``validate``, ``baselines``, ``compare``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import (
    Controller,
    Debug,
    Json,
    RobotPlanFile,
    Seed,
    Simulator,
    Trials,
    Workers,
)


def validate(
    plan: RobotPlanFile,
    simulator: Simulator = "pybullet",
    controller: Controller = "hybrid",
    trials: Trials = 1,
    seed: Seed = 0,
    perturbed: Annotated[
        bool | None,
        typer.Option("--perturbed/--nominal", help="Else: nominal if there is one trial only."),
    ] = None,
    workers: Workers = None,
    replan: Annotated[
        bool,
        typer.Option("--replan", help="After each addition plan the rest from measurements."),
    ] = False,
    replan_hold: Annotated[
        float, typer.Option(help="Simulated seconds the grasp is held meanwhile.")
    ] = 1.0,
    recover: Annotated[
        bool,
        typer.Option("--recover", help="In danger allocate forces anew, or put the finger back."),
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Record file to write.")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Carry a plan out in a physics simulator, once or in many perturbed trials.

    Example: `pivotgait validate knife.h5 --trials 100 -o record.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.validation import run_validate

    return run_validate(
        plan,
        simulator,
        controller,
        trials,
        seed,
        output,
        Output(json),
        perturbed=perturbed,
        workers=workers,
        recover=recover,
        replan_hold_s=replan_hold if replan else None,
    )


def baselines(
    plan: RobotPlanFile,
    simulator: Simulator = "pybullet",
    trials: Trials = 1,
    seed: Seed = 0,
    workers: Workers = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="JSON file to write.")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Try a plan with the same seeds under every control law, and without pivoting.

    Example: `pivotgait baselines knife.h5 --trials 100 -o baselines.json`
    """
    from pivotgait.commands.baselines import run_baselines_command
    from pivotgait.commands.output import Output

    return run_baselines_command(
        plan, simulator, trials, seed, output, Output(json), workers=workers
    )


def compare(
    plan: RobotPlanFile,
    trials: Annotated[
        int,
        typer.Option(min=0, max=100_000, help="Perturbed trials in each after the nominal run."),
    ] = 0,
    seed: Seed = 0,
    controller: Controller = "hybrid",
    causes: Annotated[
        bool | None,
        typer.Option(
            "--causes/--no-causes",
            help="Repeat with step, contacts and friction changed; else: if they do not agree.",
        ),
    ] = None,
    workers: Workers = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="Folder for records and figure; a report's shows it."),
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Carry a plan out in PyBullet and MuJoCo and tell how far the two agree.

    Example: `pivotgait compare reports/out/knife/plan.h5 --trials 100 -o reports/out/knife`
    """
    from pivotgait.commands.comparing import run_compare
    from pivotgait.commands.output import Output
    from pivotgait.validation import CompareOptions, RunOptions

    options = CompareOptions(
        run=RunOptions(controller=controller),
        trials=trials,
        seed=seed,
        causes=causes,
        workers=workers,
    )
    return run_compare(plan, options, output, Output(json))
