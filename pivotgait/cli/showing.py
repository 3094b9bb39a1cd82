"""Commands that show what was computed: ``report``, ``view``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import Debug, Json, PlanFile


def report(
    folder: Annotated[Path, typer.Argument(help="Folder of a run or of a sweep.")],
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Draw the figures of a folder's plan or sweep and write its report.html (and report.pdf).

    Example: `pivotgait report reports/out/knife`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.reporting import run_report

    return run_report(folder, Output(json))


def view(
    plan: PlanFile,
    html: Annotated[
        Path | None, typer.Option(help="Write one HTML file that needs no network, and end.")
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the local server.")
    ] = None,
    browse: Annotated[bool, typer.Option("--open/--no-open", help="Open a browser.")] = True,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Show a plan as an animated scene: arm and hand, tool, forces and friction cones.

    Example: `pivotgait view knife.h5 --html knife.html`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.viewing import run_view

    return run_view(plan, html, port, browse, Output(json))
