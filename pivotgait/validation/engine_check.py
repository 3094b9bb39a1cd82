"""Engines are packages that may be missing; such a one is refused before work is spent."""

from __future__ import annotations

from collections.abc import Collection
from importlib.util import find_spec

from pivotgait.exceptions import InputError, UnknownNameError

_EXTRAS = {"mujoco": "pip install 'pivotgait[mujoco]'"}
"""How to install what the package does not bring by itself."""


def check_engine(kind: str, name: str, known: Collection[str]) -> None:
    """Refuse an engine that cannot be used.

    Args:
        kind: what the engine is there for, as messages call it.
        name: of the engine, which is that of its package, too.
        known: names of all engines of the kind.

    Raises:
        InputError: not installed.
        UnknownNameError: no such engine.
    """
    if name not in known:
        raise UnknownNameError(kind, name, known)
    if find_spec(name) is None:
        mend = _EXTRAS.get(name, "pip install pivotgait")
        raise InputError(f"{name} is not installed", where=kind, mend=mend)
