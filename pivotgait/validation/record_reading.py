"""A recorded nominal run beside its plan, read back and checked."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import Robot, SceneConfig
from pivotgait.models.robot_loading import build_robot
from pivotgait.models.scene_yaml import read_yaml
from pivotgait.plans import GaitPlan
from pivotgait.validation.metrics import Metrics
from pivotgait.validation.planned import Planned, planned_at
from pivotgait.validation.record import RecordError, read_summary
from pivotgait.validation.series import RunSeries
from pivotgait.validation.slips import fingertip_slips, tip_slip
from pivotgait.validation.verdict import Verdict, orientation_errors

_MEND = "write it with 'pivotgait validate -o'"
_GROUP = "runs/0000"


@dataclass(frozen=True, eq=False)
class RecordedMotion(FrozenArrays):
    """The N recorded rows of a run and what follows from them.

    Attributes:
        series: what was measured; times of unwanted touches are not recorded.
        planned: the plan at the same times.
        tip_slip: (N,) way of the tip along the table [m].
        fingertip_slips: finger's name -> (N,) way of its tip along the tool's surface [m].
        orientation_error: (N,) angle from the planned orientation [rad].
        torque_share: (N, nv) torque asked for over the joint's limit.
    """

    series: RunSeries
    planned: Planned
    tip_slip: Array
    fingertip_slips: Mapping[str, Array]
    orientation_error: Array
    torque_share: Array

    @classmethod
    def of(cls, plan: GaitPlan, robot: Robot, series: RunSeries) -> RecordedMotion:
        """What follows from the rows of a run of ``plan`` with its robot."""
        planned = planned_at(plan, series.followed, series.fingers)
        limit = np.where(robot.effort_max > 0.0, robot.effort_max, np.inf)
        return cls(
            series=series,
            planned=planned,
            tip_slip=tip_slip(series),
            fingertip_slips=MappingProxyType(fingertip_slips(robot, series, planned)),
            orientation_error=orientation_errors(series, planned),
            torque_share=series.tau / limit,
        )


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """One nominal run.

    Attributes:
        simulator: that carried it out.
        controller: that was asked.
        verdict: of the rule.
        metrics: over all control cycles, None where nothing ran.
        motion: None where nothing ran, or the run ended before the plan's second sample.
    """

    simulator: str
    controller: str
    verdict: Verdict
    metrics: Metrics | None
    motion: RecordedMotion | None


class _Damaged(Exception):
    """What is wrong with a record."""


def read_run(path: Path | str, plan: GaitPlan) -> RecordedRun:
    """The first run of a record of nominal runs.

    Raises:
        RecordError: missing, damaged, of another schema or plan, or of perturbed trials.
    """
    import h5py

    path = Path(path)
    summary = read_summary(path, plan)
    if summary.get("perturbed") is not False:
        mend = "give the record of a nominal run"
        raise RecordError("holds perturbed trials", where=path.name, mend=mend)
    try:
        verdict, metrics = _judged(summary)
        with h5py.File(path, "r") as file:
            motion = _motion(file[_GROUP], plan)
        simulator, controller = str(summary["simulator"]), str(summary["controller"])
    except (OSError, KeyError, ValueError, TypeError, IndexError, RuntimeError, _Damaged) as error:
        what = f"is damaged: {error}" if isinstance(error, _Damaged) else "is damaged"
        raise RecordError(what, where=path.name, mend=_MEND) from error
    return RecordedRun(simulator, controller, verdict, metrics, motion)


def _judged(summary: Mapping[str, Any]) -> tuple[Verdict, Metrics | None]:
    told = summary["runs"][0]
    words = {key: told[key] or "" for key in ("failure", "stage", "detail")}
    data = {"passed": told["passed"], "time_s": told["time_s"] or 0.0, **words}
    metrics = told["metrics"]
    try:
        verdict = TypeAdapter(Verdict).validate_json(json.dumps(data), strict=True)
        if not metrics:
            return verdict, None
        return verdict, TypeAdapter(Metrics).validate_json(json.dumps(metrics), strict=True)
    except ValidationError as error:
        raise _Damaged("its summary") from error


def _motion(group: Any, plan: GaitPlan) -> RecordedMotion | None:
    if "time" not in group:
        return None
    robot = _robot_of(plan)
    series = _series(group, plan, robot)
    if series.time[-1] < plan.phases[0].time[1]:
        return None
    return RecordedMotion.of(plan, robot, series)


def _robot_of(plan: GaitPlan) -> Robot:
    """The plan's own arm-hand, whatever became of the files it was made from."""
    config = SceneConfig.model_validate_json(json.dumps(read_yaml(plan.scene, where="plan")))
    if plan.robot is None or config.robot is None:
        raise _Damaged("its plan has no robot")
    return build_robot(plan.robot.urdf, config.robot, where="the plan's robot")


def _series(group: Any, plan: GaitPlan, robot: Robot) -> RunSeries:
    fingers = tuple(json.loads(str(group.attrs["fingers"])))
    joints = tuple(json.loads(str(group.attrs["joint_names"])))
    if joints != robot.joint_names or not set(fingers) <= set(robot.fingers):
        raise _Damaged("its joints or fingers are not the plan's")
    count = len(group["time"])
    time = _array(group, "time", (count,))
    if count < 2 or np.any(np.diff(time) <= 0.0):
        raise _Damaged("its times do not grow")
    orientation = _array(group, "tool/orientation", (count, 4))
    if np.any(np.abs(np.linalg.norm(orientation, axis=1) - 1.0) > 1e-6):
        raise _Damaged("an orientation is no unit quaternion")

    def by_finger(name: str) -> Array:
        columns = [_array(group, f"contacts/{each}/{name}", (count, 3)) for each in fingers]
        return np.stack(columns, axis=1)

    return RunSeries(
        fingers=fingers,
        joint_names=joints,
        time=time,
        q=_array(group, "robot/q", (count, len(joints))),
        v=_array(group, "robot/v", (count, len(joints))),
        tau=_array(group, "robot/tau", (count, len(joints))),
        tool_position=_array(group, "tool/position", (count, 3)),
        tool_orientation=orientation,
        force=by_finger("force"),
        reading=by_finger("reading"),
        pivot_force=_array(group, "contacts/pivot/force", (count, 3)),
        touches=MappingProxyType({}),
        touching_table=np.zeros(0),
        diverged="",
        pivot_in_tool=plan.tool.pivot_in_tool,
        plan_time=_array(group, "plan_time", (count,)) if "plan_time" in group else None,
    )


def _array(group: Any, name: str, shape: tuple[int, ...]) -> Array:
    found = group[name]
    if found.shape != shape:
        raise _Damaged(f"{name} has shape {found.shape}")
    values = np.asarray(found[()], dtype=float)
    if not np.isfinite(values).all():
        raise _Damaged(f"{name} holds what is no finite number")
    return values
