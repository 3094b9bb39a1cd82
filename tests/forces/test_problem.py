"""Problems are checked when they are made."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from pivotgait.benchmarks.allocation import random_problem
from pivotgait.exceptions import InputError
from pivotgait.forces import LinearRows


@pytest.fixture
def problem():
    return random_problem(np.random.default_rng(0), 3, 4)


def changed(array, index, value):
    out = np.array(array)
    out[index] = value
    return out


@pytest.mark.parametrize(
    ("name", "index", "value", "match"),
    [
        ("normals", (1, 2), (0.0, 0.0, 2.0), "sample 1, contact 'index'.*unit"),
        ("friction", 3, 0.0, "friction is not positive"),
        ("friction", 3, np.nan, "contact 'middle'.*not finite"),
        ("wrench", (2, 0), np.nan, "sample 2.*wrench is not finite"),
        ("lever", (0, 1, 0), np.inf, "contact 'thumb'.*lever is not finite"),
        ("normal_min", (0, 1), 5.0, "contact 'thumb'.*normal_max < normal_min"),
        ("normal_min", (0, 1), -1.0, "negative"),
        ("normal_max", (0, 1), np.nan, "normal_max < normal_min"),
        ("normal_max", (0, slice(2)), np.inf, "squeeze without limit"),
        ("normal_fixed", (2, 1), 0.1, "sample 2, contact 'thumb'.*outside its bounds"),
        ("normal_fixed", (2, 1), np.inf, "outside its bounds"),
    ],
)
def test_bad_values_are_named(problem, name, index, value, match):
    with pytest.raises(InputError, match=match):
        replace(problem, **{name: changed(getattr(problem, name), index, value)})


@pytest.mark.parametrize("name", ["lever", "normals", "normal_min", "normal_max", "friction"])
def test_bad_shapes_are_named(problem, name):
    with pytest.raises(InputError, match=f"{name} has shape"):
        replace(problem, **{name: np.ones((2, 2))})


def test_rows_rates_and_names_are_checked(problem):
    rows = LinearRows(np.zeros((3, 1, 9)), np.zeros((3, 1)), np.zeros((3, 1)))
    with pytest.raises(InputError, match="rows have shapes"):
        replace(problem, rows=rows)
    crossed = LinearRows(np.zeros((3, 1, 12)), np.ones((3, 1)), np.zeros((3, 1)))
    with pytest.raises(InputError, match="exceeds"):
        replace(problem, rows=crossed)
    with pytest.raises(InputError, match="time step"):
        replace(problem, force_rate_max=1.0)
    with pytest.raises(InputError, match="distinct"):
        replace(problem, names=("a", "a", "b", "c"))
    with pytest.raises(InputError, match="known: alignment"):
        replace(problem, objective="grip")


def test_one_unbounded_contact_is_allowed(problem):
    high = changed(problem.normal_max, (slice(None), 0), np.inf)
    assert replace(problem, normal_max=high).samples == 3


def test_importing_forces_loads_no_solver():
    code = (
        "import sys, pivotgait.forces;"
        "print([m for m in ('cvxpy', 'clarabel', 'casadi', 'proxsuite', 'scipy.sparse')"
        " if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
