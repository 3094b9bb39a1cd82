"""Plan files on disk: written whole or not at all, read only after they were checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import PlanFileError
from pivotgait.plans.check import check_plan
from pivotgait.plans.layout import MAX_FILE_BYTES
from pivotgait.plans.plan import GaitPlan


def write_plan(plan: GaitPlan, path: Path | str) -> None:
    """Write ``plan`` as an HDF5 file of schema ``pivotgait-plan/1``.

    The same plan gives the same bytes. The file appears at once and complete: a reader sees the
    old content or the new, and a failure leaves no trace.

    Args:
        plan: the plan, with its certificate if it has one.
        path: of the file; an existing one is replaced.

    Raises:
        PlanFileError: if the plan could not be read back, or the file cannot be written.
    """
    # HDF5 is a native library: whoever only handles plans in memory need not load it.
    from pivotgait.plans.hdf5_writer import plan_to_bytes

    path = Path(path)
    check_plan(plan, where=path.name)
    image = plan_to_bytes(plan)
    if len(image) > MAX_FILE_BYTES:
        raise PlanFileError(
            f"would take {len(image) >> 20} MB", where=path.name, mend="use fewer samples or phases"
        )
    try:
        write_atomically(image, path)
    except (OSError, ValueError) as error:
        raise PlanFileError(
            f"cannot be written: {error}", where=str(path), mend="check the folder"
        ) from error


def read_plan(path: Path | str) -> GaitPlan:
    """Read a plan file.

    Args:
        path: of the file.

    Returns:
        The plan; every array finite, of the right shape, and read-only.

    Raises:
        PlanFileError: if the file is missing, damaged, too large or not of this schema, or a
            value in it cannot be meant; says what, where and how to mend.
    """
    from pivotgait.plans.hdf5_reader import plan_from_bytes

    path = Path(path)
    plan = plan_from_bytes(_read_bytes(path), where=path.name)
    check_plan(plan, where=path.name)
    return plan


def with_certificate(path: Path | str, certificate: Mapping[str, Any]) -> GaitPlan:
    """Store a certificate in a plan file.

    Args:
        path: of the file; it is replaced at once.
        certificate: plain JSON data.

    Returns:
        The plan as the file now holds it.

    Raises:
        PlanFileError: as :func:`read_plan` and :func:`write_plan`.
    """
    plan = replace(read_plan(path), certificate=certificate)
    write_plan(plan, path)
    return plan


def _read_bytes(path: Path) -> bytes:
    try:
        if not path.is_file():
            what = "is a folder" if path.is_dir() else "does not exist or is not a file"
            raise PlanFileError(what, where=str(path), mend="give the path of a plan file")
        # The size in the folder may lie (another process may be writing): read one byte too many.
        with path.open("rb") as file:
            image = file.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        raise PlanFileError(
            f"cannot be read: {error}", where=str(path), mend="check its path and permissions"
        ) from error
    if len(image) > MAX_FILE_BYTES:
        raise PlanFileError(
            f"is larger than {MAX_FILE_BYTES >> 20} MB", where=str(path), mend="use fewer samples"
        )
    return image
