"""A pytest plugin: the fixture ``cross_simulators`` holds a URDF against every engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from pivotgait.validation.crosscheck import CrossCheck


@pytest.fixture(scope="session")
def cross_simulators() -> Callable[..., CrossCheck]:
    """Fail with a table unless engines see the same robot in a URDF.

    Call it with what :func:`pivotgait.validation.crosscheck.cross_check` takes; a test whose
    engine is not installed is skipped.
    """
    # imported here: every pytest run of the environment loads this file
    from pivotgait.validation.crosscheck import ENGINES, cross_check

    def check(urdf: Path | str, **options: Any) -> CrossCheck:
        for engine in options.get("engines", ENGINES):
            pytest.importorskip(engine)
        found = cross_check(urdf, **options)
        if not found.agrees:
            pytest.fail(found.table(), pytrace=False)
        return found

    return check
