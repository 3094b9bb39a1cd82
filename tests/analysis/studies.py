"""Studies as modules, which their file names, beginning with a number, do not allow to import."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

ANALYSIS = Path(__file__).parents[2] / "analysis"
sys.path.insert(0, str(ANALYSIS))  # as for a script: studies import what they share


def load_study(name: str) -> ModuleType:
    """A study, or what studies share, as a new module.

    Args:
        name: that its file's name begins with.
    """
    (file,) = ANALYSIS.glob(f"{name}*.py")
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module
