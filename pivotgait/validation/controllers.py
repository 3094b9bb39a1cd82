"""Control laws by the names of the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pivotgait.control.controller import Controller
from pivotgait.control.hybrid import HybridController
from pivotgait.control.reference import Reference
from pivotgait.exceptions import UnknownNameError

CONTROLLERS: Mapping[str, Callable[[Reference], Controller]] = {"hybrid": HybridController}
"""Makers by name."""


def check_controller(name: str) -> None:
    """Refuse a name before work is spent.

    Raises:
        UnknownNameError: listing the control laws.
    """
    if name not in CONTROLLERS:
        raise UnknownNameError("controller", name, CONTROLLERS)


def make_controller(name: str, reference: Reference) -> Controller:
    """A control law that follows ``reference``.

    Raises:
        UnknownNameError: listing the control laws.
    """
    check_controller(name)
    return CONTROLLERS[name](reference)
