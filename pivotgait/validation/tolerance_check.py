"""Tolerances are positive numbers; others are refused."""

from __future__ import annotations

from typing import Any

from pivotgait.exceptions import InputError


def check_tolerances(tolerances: Any) -> None:
    """Refuse a dataclass of tolerances unless each is a positive, finite number.

    Raises:
        InputError: naming the first that is not.
    """
    for name, value in vars(tolerances).items():
        if not 0.0 < value < float("inf"):
            what = f"{name} of {value:g}"
            raise InputError(what, where="tolerances", mend="give a positive number")
