"""How long ``import pivotgait`` takes."""

from __future__ import annotations

import subprocess
import sys
from time import perf_counter
from typing import Any


def import_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Import time over that of the bare interpreter, least of several fresh processes."""
    repeats = 3 if quick else 7
    bare = min(_run("pass") for _ in range(repeats))
    ours = min(_run("import pivotgait") for _ in range(repeats))
    return [
        {
            "name": "import pivotgait",
            "ours_s": max(ours - bare, 0.0),
            "peer": None,
            "peer_s": None,
            "ratio": None,
        }
    ]


def _run(statement: str) -> float:
    began = perf_counter()
    subprocess.run([sys.executable, "-c", statement], check=True)
    return perf_counter() - began
