"""The certificate shares no code with what it judges."""

from __future__ import annotations

import ast
from pathlib import Path

import pivotgait.certification

FOLDER = Path(pivotgait.certification.__file__).parent
OURS = {"certification", "exceptions", "frozen", "models", "plans", "kinematics"}
THEIRS = {"__future__", "collections", "dataclasses", "math", "pathlib", "types", "typing"}
THEIRS |= {"numpy", "scipy", "coal", "pinocchio"}


def test_imports_nothing_of_the_planners() -> None:
    for file in FOLDER.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{file.name}: relative import"
                names = [node.module or ""]
            else:
                continue
            for name in names:
                parts = name.split(".")
                if parts[0] == "pivotgait":
                    assert parts[1] in OURS, f"{file.name} imports {name}"
                else:
                    assert parts[0] in THEIRS, f"{file.name} imports {name}"
