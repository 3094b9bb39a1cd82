"""What the studies share: their command line, and results as JSON."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any


def plain(value: Any) -> Any:
    """The same with null for what is not finite, which JSON does not know."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_results(path: Path, results: dict[str, Any]) -> None:
    """Write results as JSON, with null for what is not finite; the folder is made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(plain(results), indent=1, allow_nan=False) + "\n")


def run_from_command_line(
    main: Callable[..., Any], about: str | None, out: Path, **more: dict[str, Any]
) -> None:
    """Call ``main(quick, out, ...)`` with what the command line says.

    Args:
        main: of the study.
        about: its docstring.
        out: default folder.
        more: name -> what ``add_argument`` takes, for each further option.
    """
    parser = argparse.ArgumentParser(description=(about or "").strip().splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few cells")
    parser.add_argument("--out", type=Path, default=out)
    for name, options in more.items():
        parser.add_argument(f"--{name}", **options)
    main(**vars(parser.parse_args()))
