"""Whether single values of a plan are numbers that one can compute with."""

from __future__ import annotations

import numpy as np

from pivotgait.exceptions import PlanFileError
from pivotgait.frozen import Array

LARGEST = 1e12
"""No quantity of a plan is larger, in any SI unit; squares and products stay far from overflow."""


def check_array(array: Array, shape: tuple[int, ...], where: str) -> None:
    """Refuse an array of another shape, with NaN or with values beyond :data:`LARGEST`."""
    if array.shape != shape:
        raise PlanFileError(f"has shape {array.shape}", where=where, mend=f"it must be {shape}")
    if not np.all(np.abs(array) <= LARGEST):
        raise PlanFileError(
            f"holds NaN or more than {LARGEST:g}", where=where, mend="numbers must be finite"
        )


def check_finite(value: float, where: str) -> None:
    """Refuse NaN and values beyond :data:`LARGEST`."""
    if not abs(value) <= LARGEST:
        raise PlanFileError(f"is {value:g}", where=where, mend="numbers must be finite")
