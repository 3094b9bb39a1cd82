"""A control cycle against what Pinocchio itself needs for the same robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.benchmarks.relocation import Grip, knife_grip
from pivotgait.control import HybridController, Measurement, Reference
from pivotgait.frozen import Array
from pivotgait.kinematics import ClosedChain, Hold, project
from pivotgait.models import Robot, load_scene
from pivotgait.phases.timing import quintic
from pivotgait.phases.tracking import JointMotion, Waypoints, track, with_torques
from pivotgait.planning.tool_path import PivotingTool
from pivotgait.plans import (
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    ToolMotion,
)
from pivotgait.plans.plan import PhaseKind

SAMPLES = 31
DURATION_S = 0.6
TURN = (0.0, np.radians(-4.0), np.radians(6.0))
"""Rotation vector of the knife about its tip while three fingers hold it, world [rad]."""
SWING = 0.15
"""Of the middle finger's joints while it is in the air [rad]."""
NORMAL, TANGENT = 3.0, 0.6
"""Force of each finger on the knife [N]."""
FRICTION = 0.8
NOISE = 1e-4
"""Of measured joint positions [rad] and speeds [rad/s]."""
CYCLES, QUICK_CYCLES = 3000, 600


def held_knife_plan() -> GaitPlan:
    """Three fingers turn the knife about its tip; then the middle finger moves in the air.

    Made to exercise a controller, not to be carried out: the forces do not balance the weight.
    """
    grip, scene = knife_grip(), load_scene("knife")
    robot, tool = grip.world.robot, scene.tool
    time = np.linspace(0.0, DURATION_S, SAMPLES)
    holds = tuple(grip.holds.values())
    turning, resting = _tool_motions(grip, tool.pivot_in_tool, time)
    last = turning.rotation[-1].as_matrix(), turning.position[-1]
    end = project(ClosedChain(robot, holds), grip.q, *last).q
    through = Waypoints(np.array([0.0, SAMPLES - 1.0]), np.stack((grip.q, end)))
    turned = track(robot, holds, time, turning, through)
    swung = _swing(robot, end, time)
    return GaitPlan(
        scene=scene.yaml,
        seed=0,
        versions={},
        gravity=scene.gravity,
        table_height=scene.table.height,
        tool=PlannedTool(
            tool.name,
            tool.mass,
            tool.inertia,
            tool.pivot_in_tool,
            tool.urdf,
            tool.centre_of_mass_in_root,
        ),
        phases=(
            _phase(robot, ("00_removal", "removal"), time, turning, holds, turned),
            _phase(robot, ("01_relocation", "relocation"), time, resting, holds[:2], swung),
        ),
        robot=PlannedRobot(
            urdf=robot.urdf,
            joint_names=robot.joint_names,
            fingers={
                name: PlannedFinger(finger.tip_frame, finger.tip_radius)
                for name, finger in robot.fingers.items()
            },
        ),
    )


def control_rows(quick: bool = False) -> list[dict[str, Any]]:
    """Median control cycle of the hybrid law over Pinocchio's own share of it.

    The peer is ``computeAllTerms``, the four frame Jacobians and one nv x nv solve: what any
    controller of this robot with the same task needs. Both run over the same states.
    """
    reference = Reference.of(held_knife_plan())
    controller = HybridController(reference)
    readings = near_readings(reference, QUICK_CYCLES if quick else CYCLES)
    ours = _median(controller.torque, readings)
    peer = _median(_pinocchio_share(reference.robot), readings)
    return [
        {
            "name": "control cycle, hybrid law",
            "ours_s": ours,
            "peer": "Pinocchio: computeAllTerms, Jacobians, solve",
            "peer_s": peer,
            "ratio": peer / ours,
        }
    ]


def near_readings(reference: Reference, count: int) -> list[Measurement]:
    """Readings near the plan, evenly over its time."""
    rng = np.random.default_rng(0)
    readings = []
    for time in np.linspace(0.0, reference.duration, count, endpoint=False):
        wanted = reference.at(float(time))
        tool, holds = wanted.tool, reference.phases[wanted.phase].holds
        off = NOISE * rng.normal(size=(2, len(wanted.q)))
        forces = wanted.force_in_tool @ tool.rotation.T
        readings.append(
            Measurement(
                time=float(time),
                q=wanted.q + off[0],
                v=wanted.v + off[1],
                force={hold.finger.name: force for hold, force in zip(holds, forces, strict=True)},
                tool_position=tool.position,
                tool_rotation=tool.rotation,
                tool_linear_velocity=tool.linear_velocity,
                tool_angular_velocity=tool.angular_velocity,
            )
        )
    return readings


def _pinocchio_share(robot: Robot) -> Callable[[Measurement], Array]:
    model, data = robot.model, robot.model.createData()
    frames = [finger.tip_frame_id for finger in robot.fingers.values()] + [robot.palm_frame_id]

    def cycle(measurement: Measurement) -> Array:
        pin.computeAllTerms(model, data, measurement.q, measurement.v)
        for frame in frames:
            pin.updateFramePlacement(model, data, frame)
            pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        return np.linalg.solve(data.M, data.nle)

    return cycle


def _median(cycle: Callable[[Measurement], Array], readings: Sequence[Measurement]) -> float:
    spent = []
    for measurement in readings:
        began = perf_counter()
        cycle(measurement)
        spent.append(perf_counter() - began)
    return float(np.median(spent))


def _tool_motions(grip: Grip, pivot_in_tool: Array, time: Array) -> tuple[ToolMotion, ToolMotion]:
    """The knife turning about its tip, and resting where that ends."""
    turn, position = grip.tool.pose(0.0)
    path = PivotingTool(turn, position, position + turn @ pivot_in_tool, np.array(TURN))
    samples = list(zip(*quintic(time, DURATION_S), strict=True))
    return _sampled(path, samples), _sampled(path, [(1.0, 0.0, 0.0)] * len(time))


def _sampled(path: PivotingTool, samples: Sequence[tuple[float, float, float]]) -> ToolMotion:
    poses = [path.pose(float(s)) for s, _, _ in samples]
    motions = [path.motion(*map(float, sample)) for sample in samples]
    return ToolMotion(
        position=np.array([position for _, position in poses]),
        orientation=np.array([pin.Quaternion(turn).coeffs() for turn, _ in poses]),
        linear_velocity=np.array([motion.linear_velocity for motion in motions]),
        angular_velocity=np.array([motion.angular_velocity for motion in motions]),
        linear_acceleration=np.array([motion.linear_acceleration for motion in motions]),
        angular_acceleration=np.array([motion.angular_acceleration for motion in motions]),
    )


def _swing(robot: Robot, q: Array, time: Array) -> JointMotion:
    """The middle finger's joints move from q, all others rest."""
    direction = np.zeros(robot.nv)
    direction[list(robot.fingers["middle"].columns)] = SWING
    fraction, rate, acceleration = quintic(time, DURATION_S)
    return JointMotion(
        q + fraction[:, None] * direction,
        rate[:, None] * direction,
        acceleration[:, None] * direction,
    )


def _phase(
    robot: Robot,
    name: tuple[str, PhaseKind],
    time: Array,
    tool: ToolMotion,
    holds: Sequence[Hold],
    motion: JointMotion,
) -> Phase:
    contacts = {hold.finger.name: _contact(hold, tool) for hold in holds}
    return Phase(
        name=name[0],
        kind=name[1],
        finger="middle",
        time=time,
        tool=tool,
        contacts=contacts,
        robot=with_torques(robot, motion, contacts, tool),
    )


def _contact(hold: Hold, tool: ToolMotion) -> ContactTrack:
    in_tool = NORMAL * hold.normal + TANGENT * hold.toolRtarget[:, 0]
    return ContactTrack(
        name=hold.finger.name,
        point=hold.centre + hold.finger.tip_radius * hold.normal,
        normal=hold.normal,
        force=tool.rotation.as_matrix() @ in_tool,
        friction=FRICTION,
        normal_min=0.0,
        normal_max=2.0 * NORMAL,
    )
