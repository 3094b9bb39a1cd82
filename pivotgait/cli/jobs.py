"""Commands that do a whole job into a folder: ``run``, ``sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import Debug, Gait, Hand, Json, SceneArgument, Seed, Workers


def run(
    scene: SceneArgument,
    out: Annotated[Path, typer.Option("--out", help="Folder for plan, figures and report.")],
    seed: Seed = 0,
    gait: Gait = None,
    hand: Hand = True,
    view: Annotated[
        bool, typer.Option("--view/--no-view", help="Write view.html and run_view.html too.")
    ] = True,
    validate: Annotated[
        bool | None,
        typer.Option(
            "--validate/--no-validate",
            help="Carry the plan out in PyBullet; else: if it has a robot.",
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(min=0, max=100_000, help="Perturbed trials after the nominal run.")
    ] = 0,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Plan, certify, carry out in a simulator and report: the whole job in one command.

    Example: `pivotgait run knife --out reports/out/knife`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.reporting import ClosedLoop, run_all

    return run_all(
        scene,
        out,
        seed,
        gait,
        Output(json),
        hand=hand,
        view=view,
        closed_loop=ClosedLoop(validate, trials),
    )


def sweep(
    study: Annotated[
        str | None, typer.Argument(help="A built-in study's name or a YAML file.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for the results; goes on where it is.")
    ] = None,
    workers: Workers = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, like tcp://host:8786.")
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Tell the number of cells and the expected time.")
    ] = False,
    list_: Annotated[bool, typer.Option("--list", help="List the built-in studies.")] = False,
    export: Annotated[str | None, typer.Option(help="Print a built-in study's YAML.")] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Compute every cell of a study; killed at any moment, the same command goes on.

    Example: `pivotgait sweep knife_friction --out reports/out/friction`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.sweeping import run_sweep_command

    return run_sweep_command(
        study,
        out,
        workers,
        scheduler,
        Output(json),
        dry_run=dry_run,
        listed=list_,
        export=export,
    )
