"""Commands around the planning: ``scenes``, ``check``, ``doctor``, ``bench``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pivotgait.cli.options import Debug, Json


def scenes(
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the scenes' JSON schema.")
    ] = False,
    export: Annotated[str | None, typer.Option(help="Print a built-in scene's YAML.")] = None,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """List the built-in scenes, or print one to start from.

    Example: `pivotgait scenes --export knife > my_knife.yaml`
    """
    from pivotgait.commands.inspection import run_scenes
    from pivotgait.commands.output import Output

    return run_scenes(schema, export, Output(json))


def check(
    file: Annotated[Path, typer.Argument(help="A URDF, a scene (YAML) or a plan (HDF5).")],
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Check a URDF, a scene or a plan file before anything is computed with it.

    Example: `pivotgait check my_tool.urdf`
    """
    from pivotgait.commands.inspection import run_check
    from pivotgait.commands.output import Output

    return run_check(file, Output(json))


def doctor(json: Json = False, debug: Debug = False) -> int:
    """Check the environment: versions and one small job for each native library.

    Example: `pivotgait doctor`
    """
    from pivotgait.commands.doctor import run_doctor
    from pivotgait.commands.output import Output

    return run_doctor(Output(json))


def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer repetitions.")] = False,
    json: Json = False,
    debug: Debug = False,
) -> int:
    """Time the solvers against their peers, as ratios measured in one run.

    Example: `pivotgait bench --quick`
    """
    from pivotgait.commands.output import Output
    from pivotgait.commands.timing import run_bench

    return run_bench(quick, Output(json))
