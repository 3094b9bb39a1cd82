"""The entry point: a run of the command line, and what its end tells the shell."""

from __future__ import annotations

import os
import sys
import traceback

import typer

from pivotgait.cli.application import app
from pivotgait.exceptions import PivotGaitError


def main(arguments: list[str] | None = None) -> None:
    """Entry point: 0 success, 1 infeasible or a failed check, 2 bad input, in one line each."""
    given = sys.argv[1:] if arguments is None else arguments
    try:
        code = app(args=given, standalone_mode=False)
        sys.stdout.flush()
    except (PivotGaitError, typer.TyperException) as error:
        if "--debug" in given:
            traceback.print_exc()
        code = _complain(error)
    except (KeyboardInterrupt, typer.Abort):
        sys.stderr.write("pivotgait: stopped\n")
        code = 130
    except (BrokenPipeError, SystemExit):  # typer exits with 1 where it meets a broken pipe
        # whoever read our output has gone: nothing more can be written, nor was all said, so
        # that this is no success; 141 is what the shell gives other programs then
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 141
    sys.exit(code or 0)


def _complain(error: PivotGaitError | typer.TyperException) -> int:
    text = error.format_message() if isinstance(error, typer.TyperException) else str(error)
    if text:  # empty where the help was printed instead
        hint = " (see pivotgait --help)" if isinstance(error, typer.TyperException) else ""
        sys.stderr.write(f"pivotgait: error: {' '.join(text.split())}{hint}\n")
    return error.exit_code
