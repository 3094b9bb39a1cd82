"""The application: its name, and its commands in the order in which the help lists them."""

from __future__ import annotations

from collections.abc import Callable

import typer

from pivotgait.cli.closed_loop import baselines, compare, validate
from pivotgait.cli.feasibility import feasibility
from pivotgait.cli.jobs import run, sweep
from pivotgait.cli.planning import certify, plan, search
from pivotgait.cli.showing import report, view
from pivotgait.cli.tools import bench, check, doctor, scenes

_COMMANDS: tuple[Callable[..., int], ...] = (
    plan,
    certify,
    validate,
    baselines,
    compare,
    run,
    sweep,
    feasibility,
    search,
    report,
    view,
    scenes,
    check,
    doctor,
    bench,
)

app = typer.Typer(
    name="pivotgait",
    help="Dynamic finger gaits on a pivoting hand tool: plan, certify and explain.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
for _command in _COMMANDS:
    app.command()(_command)
