"""A made-up but plausible gait: a knife held by thumb and index, lifted, then re-grasped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.contacts import grasp_map
from pivotgait.models.urdf import check_urdf
from pivotgait.plans.plan import (
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    RobotMotion,
    ToolMotion,
)
from pivotgait.validation import RunSeries
from pivotgait.validation.planned import planned_at
from pivotgait.validation.record_reading import RecordedMotion

GRAVITY = np.array([0.0, 0.0, -9.81])
PIVOT_IN_TOOL = np.array([0.22, 0.0, 0.014])
PIVOT_IN_WORLD = np.array([0.6, 0.1, 0.001])
CONTACTS = {
    "thumb": ((-0.045, 0.010, -0.001), (0.0, -1.0, 0.0)),
    "index": ((-0.043, -0.010, -0.001), (0.0, 1.0, 0.0)),
    "middle": ((-0.060, -0.010, -0.001), (0.0, 1.0, 0.0)),
}
URDF = (Path(__file__).parents[2] / "urdf/chef_knife/chef_knife.urdf").read_text()


def _motion(pitch, rate, acceleration, roll=None):
    roll = np.zeros_like(pitch) if roll is None else roll
    turn = Rotation.from_euler("ZYX", np.column_stack((0.4 + 0 * pitch, pitch, roll)))
    axis = turn.apply([0.0, 1.0, 0.0])
    omega, alpha = axis * rate[:, None], axis * acceleration[:, None]
    lever = turn.apply(PIVOT_IN_TOOL)
    velocity = -np.cross(omega, lever)
    gain = -np.cross(alpha, lever) - np.cross(omega, np.cross(omega, lever))
    return ToolMotion(PIVOT_IN_WORLD - lever, turn.as_quat(), velocity, omega, gain, alpha)


def _tracks(motion, squeeze):
    """Contacts that balance gravity; ``squeeze`` maps a finger to its (N,) push [N]."""
    names = ["pivot", *squeeze]
    count = len(motion.position)
    forces = {name: np.zeros((count, 3)) for name in names}
    for k in range(count):
        turn = motion.rotation[k]
        lever = np.array(
            [turn.apply(PIVOT_IN_TOOL), *(turn.apply(CONTACTS[n][0]) for n in squeeze)]
        )
        push = [np.array([0.0, 0.0, 0.6])]
        push += [squeeze[n][k] * turn.apply(CONTACTS[n][1]) for n in squeeze]
        wanted = np.concatenate(push)
        weight = np.repeat([0.1, *(squeeze[n][k] / 6.0 + 1e-9 for n in squeeze)], 3)
        weight[:2] = 1e-2
        load = np.concatenate((0.225 * (motion.linear_acceleration[k] - GRAVITY), np.zeros(3)))
        g = grasp_map(lever)
        scaled = g * weight
        fix = weight * (g.T @ np.linalg.lstsq(scaled @ g.T, load - g @ wanted, rcond=1e-10)[0])
        for name, force in zip(names, (wanted + fix).reshape(-1, 3), strict=True):
            forces[name][k] = force
    tracks = {
        "pivot": ContactTrack(
            "pivot", PIVOT_IN_WORLD, np.array([0.0, 0.0, 1.0]), forces["pivot"], 0.6, 0.05, 20.0
        )
    }
    for name in squeeze:
        point, normal = CONTACTS[name]
        tracks[name] = ContactTrack(
            name, np.array(point), np.array(normal), forces[name], 0.8, 0.0, 15.0
        )
    return tracks


def knife_plan(certificate=None, scene="tool: knife\nseed: 1\n"):
    samples = 33
    s = np.linspace(0.0, 1.0, samples)
    smooth, slope = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 - 60 * s**3 + 30 * s**4
    bend = 60 * s - 180 * s**2 + 120 * s**3
    low, high, end = np.radians([4.0, 24.0, 27.0])
    rest = np.zeros(samples)

    def moving(start, stop, duration, roll=None):
        swing = stop - start
        return _motion(
            start + swing * smooth, swing * slope / duration, swing * bend / duration**2, roll
        )

    six = np.full(samples, 6.0)
    lift = moving(low, high, 0.8)
    still = moving(high, high, 1.0)
    last = moving(high, end, 1.0, roll=np.radians(6.0) * smooth)
    phases = (
        Phase("00_lift", "lift", "", 0.8 * s, lift, _tracks(lift, {"thumb": six, "index": six})),
        Phase(
            "01_relocation",
            "relocation",
            "middle",
            0.5 * s,
            still,
            _tracks(still, {"thumb": six, "index": six}),
        ),
        Phase(
            "02_addition",
            "addition",
            "middle",
            0.4 * s,
            still,
            _tracks(still, {"thumb": six + 4 * s, "index": six + rest, "middle": 4 * s}),
        ),
        Phase(
            "03_removal",
            "removal",
            "index",
            1.0 * s,
            last,
            _tracks(last, {"thumb": 10 - 3 * s, "index": 6 * (1 - s), "middle": 4 + 3 * s}),
        ),
    )
    tool = PlannedTool(
        "knife",
        0.225,
        np.diag([1.85e-5, 1.212e-3, 1.198e-3]),
        PIVOT_IN_TOOL,
        URDF,
        np.array([-0.22, 0.0, -0.014]),
    )
    return GaitPlan(
        scene, 1, {"pivotgait": "0.1.0"}, GRAVITY, 0.0, tool, phases, certificate=certificate
    )


ROBOT_URDF = (
    Path(__file__).parents[2] / "urdf/cobra_s800_shadow/cobra_s800_shadow.urdf"
).read_text()
FINGERS = MappingProxyType(
    {
        "thumb": PlannedFinger("thtip", 0.0075),
        "index": PlannedFinger("fftip", 0.006),
        "middle": PlannedFinger("mftip", 0.006),
    }
)


def with_robot(plan):
    """The plan with an arm-hand that moves smoothly in the middle of its joints' ranges.

    Its fingers do not hold the tool; torques reach 40 % and speeds about 10 % of their limits.
    """
    joints = [j for j in check_urdf(ROBOT_URDF, where="robot").joints.values() if j.kind != "fixed"]
    lower, upper, effort = np.array([(j.lower, j.upper, j.effort) for j in joints]).T
    rng = np.random.default_rng(3)
    start = rng.uniform(-0.3, 0.3, len(joints))
    phases = []
    for phase in plan.phases:
        t, end = phase.time[:, None], phase.time[-1]
        swing = rng.uniform(-0.1, 0.1, len(joints))
        turn = np.pi / end
        share = start + swing * (1 - np.cos(turn * t)) / 2
        half = (upper - lower) / 2
        motion = RobotMotion(
            (lower + upper) / 2 + half * share,
            half * swing * turn * np.sin(turn * t) / 2,
            half * swing * turn**2 * np.cos(turn * t) / 2,
            0.4 * effort * np.sin(3 * t + np.arange(len(joints))),
        )
        phases.append(replace(phase, robot=motion))
        start = start + swing
    robot = PlannedRobot(ROBOT_URDF, tuple(j.name for j in joints), FINGERS)
    return replace(plan, robot=robot, phases=tuple(phases))


def motion_of(plan, hold_s=0.4, every_s=0.01):
    """The record of a run that follows ``plan`` to the letter, with slips and errors made up."""
    ends = np.cumsum([phase.duration_s for phase in plan.phases])
    time = np.arange(-0.1, ends[-1] + hold_s, every_s)
    sampled = np.concatenate(
        [p.time + end - p.duration_s for p, end in zip(plan.phases, ends, strict=True)]
    )

    def joined(name, part="robot"):
        values = np.concatenate([getattr(getattr(p, part), name) for p in plan.phases])
        return np.stack([np.interp(time, sampled, column) for column in values.T], axis=1)

    fingers = tuple(plan.robot.fingers)
    planned = planned_at(plan, time, fingers)
    force = np.einsum("nij,nkj->nki", planned.rotation.as_matrix(), planned.force)
    series = RunSeries(
        fingers=fingers,
        joint_names=plan.robot.joint_names,
        time=time,
        q=joined("q"),
        v=joined("v"),
        tau=joined("tau"),
        tool_position=joined("position", "tool"),
        tool_orientation=planned.orientation,
        force=force,
        reading=force,
        pivot_force=planned.pivot_force,
        touches={},
        touching_table=np.zeros(0),
        diverged="",
        pivot_in_tool=plan.tool.pivot_in_tool,
    )
    begun = np.maximum(time, 0.0)
    return RecordedMotion(
        series,
        planned,
        tip_slip=1e-4 * begun,
        fingertip_slips=dict.fromkeys(fingers, 0.0002 * begun),
        orientation_error=np.radians(0.3 * begun),
        torque_share=0.1 * np.sin(begun[:, None] + np.arange(len(plan.robot.joint_names))),
    )
