"""Errors of studies and of the folders their results go to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pivotgait.exceptions import InputError, PivotGaitError, SceneError


class StudyError(InputError):
    """A study file that cannot be read, or whose values contradict each other."""


class SweepFolderError(InputError):
    """A folder that holds something else than this study's results."""


class SweepError(PivotGaitError):
    """A sweep that cannot go on: processes that do not start, or die outside any cell."""


@contextmanager
def of_a_study() -> Iterator[None]:
    """Tell what the shared readers of YAML files find as an error of the study."""
    try:
        yield
    except SceneError as error:
        raise StudyError(error.what, where=error.where, mend=error.mend) from error
