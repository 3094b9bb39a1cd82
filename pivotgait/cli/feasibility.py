"""The command that judges a gait: ``feasibility``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import Debug, Gait, Json, SceneArgument, Seed


def feasibility(
    scene: SceneArgument,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="Change a parameter first, e.g. `contacts.*.friction=0.4`; may be repeated.",
        ),
    ] = None,
    gait: Gait = None,
    turn_max: Annotated[
        float | None,
        typer.Option(help="Largest turn of the tool in a removal [deg]; 0 for no pivoting."),
    ] = None,
    hand: Annotated[
        bool, typer.Option("--hand/--no-hand", help="Plan the arm-hand too; keep its torques.")
    ] = False,
    mends: Annotated[int, typer.Option(min=0, max=20, help="Most mends to look for.")] = 3,
    maps: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="PATH=LO:HI",
            help="A map in place of one verdict, over two parameters; a third gives slices, "
            "`removed=FINGER,FINGER` those without each finger.",
        ),
    ] = None,
    phase: Annotated[
        str | None,
        typer.Option(help="Of a map: after which phase; else the gait's first removal or lift."),
    ] = None,
    quantity: Annotated[str, typer.Option(help="Of a map: depth, margin or turn.")] = "depth",
    tolerance: Annotated[
        float | None, typer.Option(help="Of a map's border, share of an axis; else 1/128.")
    ] = None,
    spread: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=SD",
            help="Of a map: draw a parameter, and show the share of draws that hold, too.",
        ),
    ] = None,
    draws: Annotated[int, typer.Option(min=1, max=100_000, help="Of --spread, a point.")] = 64,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the map.")] = None,
    seed: Seed = 0,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Judge a gait: feasible or not, what binds, the nearest changes that mend it, the margins.

    Examples: `pivotgait feasibility knife`,
    `pivotgait feasibility knife --set 'contacts.*.friction=0.3'`,
    `pivotgait feasibility knife --set tool.mass_scale=4 --json`,
    `pivotgait feasibility knife --turn-max 0`,
    `pivotgait feasibility knife --map contacts.*.friction=0.2:1.2 --map tool.pitch_deg=10:50`
    """
    from pivotgait.commands.feasibility import run_feasibility
    from pivotgait.commands.output import Output
    from pivotgait.feasibility import VerdictOptions

    if maps:
        from pivotgait.commands.mapping import MapRequest, run_maps

        request = MapRequest(
            tuple(maps),
            gait,
            phase,
            quantity,
            turn_max,
            tolerance,
            tuple(spread or ()),
            draws,
            seed,
        )
        return run_maps(scene, changes or [], request, out, Output(json))
    options = VerdictOptions(gait, turn_max, hand, mends, seed=seed)
    return run_feasibility(scene, changes or [], options, Output(json))
