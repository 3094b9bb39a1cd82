"""The record of a set of trials on disk: HDF5, written whole or not at all, no pickle."""

from __future__ import annotations

import hashlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from pivotgait.atomic import write_atomically
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_writer import plan_to_bytes
from pivotgait.validation.margins import measured_margins, planned_margins
from pivotgait.validation.metrics import normal_forces
from pivotgait.validation.trial import TrialResult
from pivotgait.validation.trials import TrialSet

SCHEMA = "pivotgait-record/1"
_MOST_BYTES = 2_000_000_000
_TIMES = ("plan_time_s", "control_cycle_s", "simulator_cycle_s")
"""What differs from run to run on one machine: told by the command, kept out of the record."""


class RecordError(InputError):
    """A record that is missing, damaged, or of another plan."""


def write_record(trials: TrialSet, plan: GaitPlan, path: Path | str) -> None:
    """Write trials as an HDF5 file of schema ``pivotgait-record/1``.

    Root attributes: ``schema``, ``plan`` (:func:`plan_digest`), ``summary`` (JSON: what
    ``validate`` prints, without times of this machine). One group ``runs/NNNN`` for each trial
    with attributes ``seed``, ``passed``, ``failure``, ``fingers``, ``joint_names``, and N rows
    of: ``time`` [s], ``robot/{q,v,tau}``, ``tool/{position,orientation,planned_orientation}``,
    ``contacts/<finger>/{force,reading,normal_force,planned_normal_force,margin,planned_margin}``
    and ``contacts/pivot/{force,margin,planned_force,planned_margin}``; forces on the tool in the
    world frame [N], margins mu f_n - |f_t| [N]. Runs with recovery have ``plan_time`` [s] that was
    followed besides. The same trials give the same bytes.

    Raises:
        RecordError: the file cannot be written.
    """
    import h5py

    path, buffer = Path(path), io.BytesIO()
    summary = trials.as_json()
    summary["runs"] = [
        {key: value for key, value in each.items() if key not in _TIMES} for each in summary["runs"]
    ]
    with h5py.File(buffer, "w") as file:
        file.attrs["schema"] = SCHEMA
        file.attrs["plan"] = plan_digest(plan)
        file.attrs["summary"] = json.dumps(summary, allow_nan=False)
        for place, result in enumerate(trials.results):
            _write_run(file.create_group(f"runs/{place:04d}"), result)
    try:
        write_atomically(buffer.getvalue(), path)
    except (OSError, ValueError) as error:
        raise RecordError(f"cannot be written: {error}", where=str(path)) from error


def read_summary(path: Path | str, plan: GaitPlan | None = None) -> dict[str, Any]:
    """What a record says of its trials, as ``validate --json`` printed it but for times.

    Args:
        path: of the record.
        plan: that it must be of, if given.

    Raises:
        RecordError: missing, damaged, of another schema or another plan.
    """
    import h5py

    path = Path(path)
    mend = "write it with 'pivotgait validate -o'"
    try:
        if not path.is_file() or path.stat().st_size > _MOST_BYTES:
            raise RecordError("is no file, or too large", where=str(path)[:80], mend=mend)
        with h5py.File(path, "r") as file:
            schema, digest = str(file.attrs["schema"]), str(file.attrs["plan"])
            summary = json.loads(str(file.attrs["summary"]))
    except (OSError, KeyError, ValueError, TypeError, RuntimeError) as error:
        raise RecordError("is damaged or no record", where=path.name, mend=mend) from error
    if schema != SCHEMA or not isinstance(summary, dict):
        raise RecordError(f"has schema {schema[:40]!r}", where=path.name, mend=mend)
    if plan is not None and digest != plan_digest(plan):
        raise RecordError("is the record of another plan", where=path.name, mend=mend)
    return summary


def plan_digest(plan: GaitPlan) -> str:
    """SHA-256 of a plan's file."""
    return hashlib.sha256(plan_to_bytes(plan)).hexdigest()


def _write_run(group: Any, result: TrialResult) -> None:
    group.attrs["seed"] = result.seed
    group.attrs["passed"] = result.verdict.passed
    group.attrs["failure"] = result.verdict.failure
    series, planned = result.series, result.planned
    if series is None or planned is None:
        return
    group.attrs["fingers"] = json.dumps(series.fingers)
    group.attrs["joint_names"] = json.dumps(series.joint_names)
    margins, wanted_margins = measured_margins(series, planned), planned_margins(planned)
    data: dict[str, Array] = {
        "time": series.time,
        "robot/q": series.q,
        "robot/v": series.v,
        "robot/tau": series.tau,
        "tool/position": series.tool_position,
        "tool/orientation": series.tool_orientation,
        "tool/planned_orientation": planned.orientation,
        "contacts/pivot/force": series.pivot_force,
        "contacts/pivot/planned_force": planned.pivot_force,
        "contacts/pivot/margin": margins[1],
        "contacts/pivot/planned_margin": wanted_margins[1],
    }
    if series.plan_time is not None:
        data["plan_time"] = series.plan_time
    normal = normal_forces(series, planned)
    for k, name in enumerate(series.fingers):
        finger = {
            "force": series.force[:, k],
            "reading": series.reading[:, k],
            "normal_force": normal[:, k],
            "planned_normal_force": planned.normal_force[:, k],
            "margin": margins[0][:, k],
            "planned_margin": wanted_margins[0][:, k],
        }
        data |= {f"contacts/{name}/{key}": value for key, value in finger.items()}
    for name, values in data.items():
        # HDF5 notes times of creation unless told not to: the same run, the same bytes.
        group.create_dataset(name, data=np.asarray(values), track_times=False)
