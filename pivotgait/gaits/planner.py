"""A whole gait: what the tool feels, then the hand that does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from pivotgait import __version__
from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.gaits.hand import HandOptions, HandPlanner
from pivotgait.gaits.steps import Step, plan_steps
from pivotgait.models import RelocationPhase, Robot, Scene, Tool
from pivotgait.phases.grasp import Setting
from pivotgait.plans import GaitPlan, Phase, PlannedFinger, PlannedRobot, PlannedTool

PACKAGES = ("numpy", "scipy", "pin", "coal", "clarabel", "casadi")
"""Packages whose versions a plan carries: those its numbers depend on."""


@dataclass(frozen=True)
class PhaseDone:
    """News of the planner's progress: a phase, its place, their number, its time of planning."""

    phase: Phase
    place: int
    count: int
    plan_time_s: float


@dataclass(frozen=True)
class PosturesFound:
    """News: postures from which the whole gait can be carried out."""

    starts: int
    search_time_s: float


Progress = Callable[[PhaseDone | PosturesFound], None]


def plan_gait(
    scene: Scene,
    *,
    gait: str | None = None,
    seed: int = 0,
    hand: bool = True,
    options: HandOptions | None = None,
    progress: Progress | None = None,
) -> GaitPlan:
    """Plan every phase of a gait.

    Args:
        scene: tool, table, contacts and gaits, and maybe a robot.
        gait: which of the scene's gaits; the first without it.
        seed: of the random generator of the hand's searches; the same seed gives the same plan.
        hand: whether to plan the motion of the scene's robot; else, and in a scene without one,
            the plan holds the tool's motion and forces, and no relocations.
        options: of the hand's searches.
        progress: called after each phase, and when the hand's postures are found.

    Returns:
        The plan, without a certificate.

    Raises:
        UnknownNameError: no such gait.
        InputError: a negative seed.
        InfeasibleError: no forces, no motion or no posture satisfy a phase's constraints.
        SolverError: a solver failed otherwise.
    """
    if seed < 0:
        raise InputError(f"seed {seed} is negative", where="seed", mend="give 0 or more")
    if gait is not None and gait not in scene.gaits:
        raise UnknownNameError("gait", gait, scene.gaits, where=f"scene {scene.name}")
    configs = scene.gaits[gait or next(iter(scene.gaits))]
    robot = scene.robot if hand else None
    if robot is None:
        configs = tuple(each for each in configs if not isinstance(each, RelocationPhase))
    setting = Setting.of(scene)
    tell: Progress = progress or (lambda news: None)
    if robot is None:
        steps = plan_steps(setting, configs, lambda step, k: tell(_done(step, k, len(configs))))
        phases = tuple(step.phase for step in steps if step.phase is not None)
    else:
        steps = plan_steps(setting, configs)
        planner = HandPlanner(setting, robot, steps, np.random.default_rng(seed), options)
        found = planner.plan()
        tell(PosturesFound(found.record.starts, found.search_time_s))
        phases = found.phases
        for k, (step, phase) in enumerate(zip(steps, phases, strict=True)):
            tell(PhaseDone(phase, k, len(phases), step.plan_time_s + found.plan_time_s[k]))
    return GaitPlan(
        scene=scene.yaml,
        seed=seed,
        versions={"pivotgait": __version__, **{name: version(name) for name in PACKAGES}},
        gravity=scene.gravity,
        table_height=scene.table.height,
        tool=_planned_tool(scene.tool),
        phases=phases,
        robot=None if robot is None else _planned_robot(robot),
    )


def _done(step: Step, place: int, count: int) -> PhaseDone:
    assert step.phase is not None
    return PhaseDone(step.phase, place, count, step.plan_time_s)


def _planned_tool(tool: Tool) -> PlannedTool:
    return PlannedTool(
        name=tool.name,
        mass=tool.mass,
        inertia=tool.inertia,
        pivot_in_tool=tool.pivot_in_tool,
        urdf=tool.urdf,
        centre_of_mass_in_root=tool.centre_of_mass_in_root,
    )


def _planned_robot(robot: Robot) -> PlannedRobot:
    names = robot.joint_names
    return PlannedRobot(
        urdf=robot.urdf,
        joint_names=names,
        fingers={
            name: PlannedFinger(finger.tip_frame, finger.tip_radius)
            for name, finger in robot.fingers.items()
        },
        couplings=tuple((names[i], names[k]) for i, k in robot.couplings),
        never_touch=robot.never_touch,
    )
