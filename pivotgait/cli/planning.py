"""Commands that make a plan or prove one: ``plan``, ``certify``, ``search``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import Debug, Gait, Hand, Json, PlanFile, SceneArgument, Seed


def plan(
    scene: SceneArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help="Plan file to write.")] = Path(
        "plan.h5"
    ),
    seed: Seed = 0,
    gait: Gait = None,
    hand: Hand = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Plan every phase of a gait, certify it and write the plan file.

    Example: `pivotgait plan knife -o knife.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.planning import run_plan

    return run_plan(scene, output, seed, gait, Output(json), hand=hand)


def certify(
    plan: PlanFile,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Recompute a plan's certificate from the file alone.

    Example: `pivotgait certify knife.h5`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.planning import run_certify

    return run_certify(plan, Output(json))


def search(
    scene: SceneArgument,
    goal: Annotated[
        str,
        typer.Option(
            help="Wanted grasp: contacts of the scene or places like `index@0.03/180` (metres "
            "along the handle, degrees around it), all of them and no others; `power-grasp`, "
            "`power-grasp by thumb within 0.05 m`: a finger opposes two, and the palm is that near "
            "to the handle's axis; `lifted off by thumb_top and middle_below`, or by fingers.",
        ),
    ],
    first: Annotated[
        str | None, typer.Option(help="Contacts that lift the tool; else any two.")
    ] = None,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option("--out", help="Scene file to write.")] = None,
    sequences: Annotated[
        int, typer.Option(min=1, max=100, help="Find so many and take the cheapest.")
    ] = 1,
    time_limit: Annotated[
        float, typer.Option(min=1.0, max=86400.0, help="End after this time [s].")
    ] = 60.0,
    hand: Hand = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Find contacts and an order of gaits that lead to a wanted grasp, as a scene that replays.

    Examples: `pivotgait search knife --goal 'thumb_spine, middle_flat, index_edge_near'`,
    `pivotgait search knife --goal power-grasp --out power.yaml`, then `pivotgait plan power.yaml`,
    `pivotgait search knife --goal 'thumb@0.04/0, index@0.05/180, middle@0.03/180' --seed 1`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.searching import SearchRequest, run_search

    request = SearchRequest(goal, first, seed, out, sequences, time_limit, hand)
    return run_search(scene, request, Output(json))
