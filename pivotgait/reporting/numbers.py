"""Numbers as a reader wants them: few digits, a true minus, the unit beside."""

from __future__ import annotations

import math

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_GLUE = "\N{NO-BREAK SPACE}"
UNKNOWN = "–"
"""Stands where a value is not known."""


def number(value: object, digits: int = 3) -> str:
    """``value`` with ``digits`` significant digits, in powers of ten when far from 1.

    What is no finite number (also None) gives a dash.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return UNKNOWN
    value = value or 0  # not a negative zero
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        text = f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        power = f"10{str(int(exponent)).translate(_RAISED)}"
        text = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa} × {power}")
    return text.replace("-", "−").replace(" ", _GLUE)


def quantity(value: object, unit: str, digits: int = 3) -> str:
    """``value`` and its unit, on one line; a dash without unit where there is no value."""
    text = number(value, digits)
    return text if text == UNKNOWN or not unit else f"{text} {unit}".replace(" ", _GLUE)
