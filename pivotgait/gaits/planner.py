"""A whole gait: what the tool feels, then the hand that does it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from pivotgait import __version__
from pivotgait.exceptions import InfeasibleError, InputError, UnknownNameError
from pivotgait.forces import LinearRows
from pivotgait.gaits.hand import HandGait, HandOptions, HandPlanner
from pivotgait.gaits.steps import Step, plan_steps
from pivotgait.models import PhaseConfig, RelocationPhase, Robot, Scene, Tool
from pivotgait.phases.grasp import Setting
from pivotgait.phases.torque_limits import torque_rows, torque_share
from pivotgait.plans import GaitPlan, Phase, PlannedFinger, PlannedRobot, PlannedTool

PACKAGES = ("numpy", "scipy", "pin", "coal", "clarabel", "casadi")
"""Packages whose versions a plan carries: those its numbers depend on."""
_TORQUE_RESERVE = {"lift": 0.15, "addition": 0.02}
"""Share of torque limits left unused when forces are chosen by them: postures change a little when
the hand is planned again, and a lift's last forces hold the tool in those that follow, too."""


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
    like: GaitPlan | None = None,
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
        like: a plan of the same gait for a scene that differs a little, the tool laid elsewhere
            for instance: its postures are tried before any search.
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
        steps, found = _plan_hand(
            setting, robot, configs, np.random.default_rng(seed), options, like
        )
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


def _plan_hand(
    setting: Setting,
    robot: Robot,
    configs: Sequence[PhaseConfig],
    rng: np.random.Generator,
    options: HandOptions | None,
    like: GaitPlan | None,
) -> tuple[tuple[Step, ...], HandGait]:
    """Forces, then the hand; where its torques are too large, both again with their limits.

    Raises:
        InfeasibleError: no posture or path, or a torque limit that no forces keep.
    """
    steps = plan_steps(setting, configs)
    known = () if like is None or not _same_hand(like, robot, configs) else like.phases
    found = HandPlanner(setting, robot, steps, rng, options).plan(known)
    weak = weakest_joint(robot, found)
    if not weak:
        return steps, found
    rows = {
        phase.name: _rows(robot, step, phase)
        for step, phase in zip(steps, found.phases, strict=True)
        if phase.kind in _TORQUE_RESERVE
    }
    try:
        steps = plan_steps(setting, configs, rows=rows)
    except InfeasibleError as error:
        name, joint, share = weak
        raise InfeasibleError(
            f"within the torque limits {error.what}; without them {name} takes "
            f"{100 * share:.0f} % of the torque of {joint}",
            where=error.where,
            mend="choose other contacts or stronger joints",
        ) from error
    found = HandPlanner(setting, robot, steps, rng, options).plan_again(found)
    weak = weakest_joint(robot, found)
    if weak:
        name, joint, share = weak
        raise InfeasibleError(
            f"needs {100 * share:.0f} % of the torque of {joint}",
            where=name,
            mend="lower normal_force_N.max of the contacts or choose others",
        )
    return steps, found


def _rows(robot: Robot, step: Step, phase: Phase) -> LinearRows:
    assert phase.robot is not None
    reserve = _TORQUE_RESERVE[phase.kind]
    fingers = tuple(step.touching.values())
    return torque_rows(robot, phase.robot, phase.tool, fingers, reserve=reserve)


def weakest_joint(robot: Robot, found: HandGait) -> tuple[str, str, float] | None:
    """Phase, joint and share of the torque that is farthest beyond its limit, if one is."""
    shares = [
        (phase.name, *torque_share(robot, phase.robot.tau)) for phase in found.phases if phase.robot
    ]
    name, share, joint = max(shares, key=lambda each: each[1])
    return (name, joint, share) if share > 1.0 else None


def _same_hand(plan: GaitPlan, robot: Robot, configs: Sequence[PhaseConfig]) -> bool:
    kinds = [config.kind for config in configs]
    same = plan.robot is not None and plan.robot.joint_names == robot.joint_names
    return same and [phase.kind for phase in plan.phases] == kinds


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
