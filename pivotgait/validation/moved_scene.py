"""A plan's scene, and the same scene with the tool laid elsewhere."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from pivotgait.exceptions import InputError, PlanFileError
from pivotgait.frozen import Array
from pivotgait.models import Scene, parse_scene
from pivotgait.models.scene_yaml import read_yaml
from pivotgait.plans import GaitPlan

_WHERE = "scene of the plan"


def scene_of(plan: GaitPlan, folder: Path | None = None) -> Scene:
    """The scene a plan was made from; robot and tool must be the plan's.

    Args:
        plan: with a robot.
        folder: in which relative URDF paths start.

    Raises:
        PlanFileError: for a plan without a robot, or whose robot or tool is not the scene's.
        SceneError, UrdfError, UnknownNameError: if the scene cannot be loaded.
    """
    if plan.robot is None:
        what, mend = "holds no motion of a robot", "plan a scene with a robot, without --no-hand"
        raise PlanFileError(what, where="plan", mend=mend)
    scene = parse_scene(plan.scene, where=_WHERE, folder=folder)
    mend = "plan the scene again"
    if scene.robot is None:
        raise PlanFileError("has a robot, its scene has none", where="plan", mend=mend)
    same_joints = scene.robot.joint_names == plan.robot.joint_names
    if scene.robot.urdf != plan.robot.urdf or not same_joints:
        raise PlanFileError("the robot is not that of its scene", where="plan", mend=mend)
    same_tool = scene.tool.urdf == plan.tool.urdf and np.array_equal(
        scene.tool.pivot_in_tool, plan.tool.pivot_in_tool
    )
    if not same_tool:
        raise PlanFileError("the tool is not that of its scene", where="plan", mend=mend)
    return scene


def gait_of(plan: GaitPlan, scene: Scene) -> str:
    """Name of the scene's gait that a plan carries out.

    Raises:
        InputError: if its phases are not those of any gait.
    """
    kinds = [phase.kind for phase in plan.phases]
    for name, phases in scene.gaits.items():
        if [phase.kind for phase in phases] == kinds:
            return name
    raise InputError(
        "its phases are those of no gait of its scene", where="plan", mend="plan the scene again"
    )


def moved(scene: Scene, laid: Array, folder: Path | None = None) -> Scene:
    """The scene with the tool laid elsewhere.

    Args:
        scene: as planned.
        laid: (3,) by which the pivot moves along x and y [m] and the tool turns about it [rad].
        folder: in which relative URDF paths start.

    Raises:
        SceneError: if the tool would leave the table.
    """
    data = read_yaml(scene.yaml, where=_WHERE)
    rest = data["rest"]
    x, y = rest["pivot_m"]
    rest["pivot_m"] = [float(x + laid[0]), float(y + laid[1])]
    rest["yaw_deg"] = float(rest.get("yaw_deg", 0.0) + np.degrees(laid[2]))
    # JSON is YAML, too.
    return parse_scene(json.dumps(data, indent=1), where="moved scene", folder=folder)
