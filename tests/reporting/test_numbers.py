import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pivotgait.reporting.numbers import UNKNOWN, number, quantity

RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (-0.0, "0"),
        (1e-6, "10⁻⁶"),
        (-1e-8, "−10⁻⁸"),
        (3.66e-4, "3.66 × 10⁻⁴"),
        (0.785, "0.785"),
        (12345, "12345"),
        (2.5e9, "2.5 × 10⁹"),
        (None, UNKNOWN),
        (math.nan, UNKNOWN),
        (math.inf, UNKNOWN),
        ("3", UNKNOWN),
        (True, UNKNOWN),
    ],
)
def test_number(value, text):
    assert number(value).replace("\N{NO-BREAK SPACE}", " ") == text


@given(st.floats(-1e12, 1e12))
def test_number_reads_back_within_its_digits(value):
    text = number(value).translate(RAISED).replace("\N{NO-BREAK SPACE}", "")
    if "10-" in text or "×" in text or (text.lstrip("-").startswith("10") and abs(value) >= 1e5):
        mantissa, _, power = text.rpartition("10") if "×" not in text else text.partition("×10")
        sign = -1.0 if text.startswith("-") else 1.0
        mantissa = mantissa.rstrip("×").strip("-") or "1"
        read = sign * float(mantissa) * 10.0 ** int(power)
    else:
        read = float(text)
    assert read == pytest.approx(value, rel=6e-3, abs=1e-300)


def test_quantity_keeps_value_and_unit_on_one_line():
    assert " " not in quantity(3.66e-4, "N m")
    assert quantity(0.25, "") == "0.25"
    assert quantity(None, "N") == UNKNOWN
