"""Control laws by the names of the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pivotgait.control import (
    AdmittanceController,
    Controller,
    FeedForwardController,
    HybridController,
    PositionController,
    Reference,
)
from pivotgait.exceptions import UnknownNameError

CONTROLLERS: Mapping[str, Callable[[Reference, float], Controller]] = {
    "hybrid": lambda reference, period: HybridController(reference),
    "admittance": lambda reference, period: AdmittanceController(reference, period=period),
    "position": lambda reference, period: PositionController(reference, period=period),
    "feedforward": lambda reference, period: FeedForwardController(reference),
}
"""Makers by name, of a reference and the length of a control cycle [s]."""


def check_controller(name: str) -> None:
    """Refuse a name before work is spent.

    Raises:
        UnknownNameError: listing the control laws.
    """
    if name not in CONTROLLERS:
        raise UnknownNameError("controller", name, CONTROLLERS)


def make_controller(name: str, reference: Reference, period: float) -> Controller:
    """A control law that follows ``reference`` in cycles of ``period`` [s].

    Raises:
        UnknownNameError: listing the control laws.
    """
    check_controller(name)
    return CONTROLLERS[name](reference, period)
