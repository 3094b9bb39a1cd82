"""Small studies."""

from __future__ import annotations

import pytest

from pivotgait.sweeps import Study, parse_study
from tests.sweeps.cases import DRAWN, GRID


@pytest.fixture(scope="session")
def grid() -> Study:
    """30 static cells on a grid."""
    return parse_study(GRID)


@pytest.fixture(scope="session")
def drawn() -> Study:
    """2 places of a grid with 10 draws each."""
    return parse_study(DRAWN)
