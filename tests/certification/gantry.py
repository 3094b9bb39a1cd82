"""An arm-hand whose joints are known in closed form for every motion of its fingertips.

Each finger is a gantry: three slides along the world's axes, then three hinges about x, y and z
that meet in the tip's centre. A tip at p with rotation R hence has the slides p and the Euler
angles of R = Rx Ry Rz. Fingers turn with the tool, so that nothing rolls or slips.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from pivotgait.plans import (
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    RobotMotion,
    ToolMotion,
)

RADIUS = 0.005
FINGERS = {"thumb": 1.0, "index": -1.0, "middle": -1.0}
"""Finger -> side of the handle along y on which its stem stands."""

_LINK = """  <link name="{name}">
    <inertial>
      <origin xyz="{lever}" rpy="0 0 0"/>
      <mass value="{mass}"/>
      <inertia ixx="1e-5" ixy="0" ixz="0" iyy="2e-5" iyz="0" izz="1.5e-5"/>
    </inertial>
{shape}  </link>
"""
_JOINT = """  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="0 0 0" rpy="0 0 0"/>
    <axis xyz="{axis}"/>
    <limit lower="-1.5" upper="1.5" effort="{effort}" velocity="3"/>
  </joint>
"""
_SHAPE = """    <collision name="{name}">
      <origin xyz="{xyz}" rpy="{rpy}"/>
      <geometry>
        {geometry}
      </geometry>
    </collision>
"""
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}


def urdf() -> str:
    """Text of the gantry's URDF: its root stands in the world, half below the table."""
    box = _SHAPE.format(
        name="frame", xyz="-0.3 0 0", rpy="0 0 0", geometry='<box size="0.1 0.1 0.1"/>'
    )
    fingers = "".join(_finger(name, side) for name, side in FINGERS.items())
    return (
        '<?xml version="1.0"?>\n<robot name="gantry" version="1.1">\n'
        f'  <link name="frame">\n{box}  </link>\n{fingers}</robot>\n'
    )


def _finger(name: str, side: float) -> str:
    text, parent = "", "frame"
    for kind, effort in (("prismatic", 50), ("revolute", 2)):
        for axis, direction in _AXES.items():
            joint = f"{name}_{'slide' if kind == 'prismatic' else 'hinge'}_{axis}"
            last = kind == "revolute" and axis == "z"
            stem = _SHAPE.format(
                name=f"{name}_stem",
                xyz=f"0 {0.022 * side} 0",
                rpy="1.5707963267948966 0 0",
                geometry='<capsule radius="0.003" length="0.03"/>',
            )
            text += _LINK.format(
                name=joint,
                mass=0.05 if last else 0.2,
                lever=f"0.002 {0.02 * side} 0.001" if last else "0 0 0",
                shape=stem if last else "",
            )
            text += _JOINT.format(
                name=f"{joint}_joint", kind=kind, parent=parent, child=joint, axis=direction,
                effort=effort,
            )  # fmt: skip
            parent = joint
    tip = _SHAPE.format(
        name=f"{name}_ball", xyz="0 0 0", rpy="0 0 0", geometry=f'<sphere radius="{RADIUS}"/>'
    )
    return (
        f'{text}  <link name="{name}_tip">\n{tip}  </link>\n'
        f'  <joint name="{name}_fixed" type="fixed">\n    <parent link="{parent}"/>\n'
        f'    <child link="{name}_tip"/>\n  </joint>\n'
    )


def planned_gantry() -> PlannedRobot:
    """The gantry as a plan's robot; the index never passes the middle finger along x."""
    text = urdf()
    return PlannedRobot(
        urdf=text,
        joint_names=tuple(pin.buildModelFromXML(text).names[1:]),
        fingers={name: PlannedFinger(f"{name}_tip", RADIUS) for name in FINGERS},
        couplings=(("index_slide_x_joint", "middle_slide_x_joint"),),
    )


def with_gantry(plan: GaitPlan, *, hover: float = 0.015, bump: float = 0.012) -> GaitPlan:
    """The plan of tests with the gantry; the middle finger gets a relocation to its contact.

    Args:
        plan: lift, addition of middle, removal, relocation and addition of index.
        hover: distance [m] of the middle fingertip from the tool before it comes.
        bump: height [m] of the index finger's way over the tool.
    """
    lift, add, *rest = plan.phases
    phases = [lift, _approach(lift, "middle"), add, *rest]
    phases = [replace(p, name=f"{k:02d}_{p.kind}") for k, p in enumerate(phases)]
    robot = planned_gantry()
    start = lift.tool.rotation[0]
    held = {
        name: _touching(_first_contact(phases, name), hover if name == "middle" else 0.0)
        for name in FINGERS
    }
    moved = []
    for place, phase in enumerate(phases):
        courses = {name: _resting(at, phase) for name, at in held.items()}
        if phase.kind == "relocation":
            contact = _first_contact(phases[place:], phase.finger)
            goal = _touching(contact, 0.0)
            detour = 0.0 if phase.finger == "middle" else bump
            courses[phase.finger] = _transfer(
                held[phase.finger], goal, -detour * contact.normal, phase
            )
            held[phase.finger] = goal
        moved.append(replace(phase, robot=joint_motion(robot, plan, phase, courses, start)))
    return replace(plan, robot=robot, phases=tuple(moved))


def _first_contact(phases: list[Phase], name: str) -> ContactTrack:
    return next(phase.contacts[name] for phase in phases if name in phase.contacts)


def _touching(contact: ContactTrack, hover: float) -> np.ndarray:
    return np.asarray(contact.point - (RADIUS + hover) * contact.normal)


def _approach(lift: Phase, finger: str) -> Phase:
    """A relocation while the tool rests as the lift leaves it."""
    count, zero = lift.time.size, np.zeros((lift.time.size, 3))

    def still(array: np.ndarray) -> np.ndarray:
        return np.tile(array[-1], (count, 1))

    tool = ToolMotion(
        still(lift.tool.position), still(lift.tool.orientation), zero, zero, zero, zero
    )
    contacts = {n: replace(c, force=still(c.force)) for n, c in lift.contacts.items()}
    return Phase("01_relocation", "relocation", finger, lift.time, tool, contacts)


Course = tuple[np.ndarray, np.ndarray, np.ndarray]
"""(N, 3) tip centre in the tool frame, and its two time derivatives there."""


def _resting(at: np.ndarray, phase: Phase) -> Course:
    zero = np.zeros((phase.time.size, 3))
    return zero + at, zero, zero


def _transfer(start: np.ndarray, goal: np.ndarray, bump: np.ndarray, phase: Phase) -> Course:
    """Quintic from start to goal with a detour of size ``bump`` in the middle."""
    total = phase.duration_s
    s = (phase.time / total)[:, None]
    u = 10 * s**3 - 15 * s**4 + 6 * s**5
    u1 = 30 * (s**2 - 2 * s**3 + s**4) / total
    u2 = 60 * (s - 3 * s**2 + 2 * s**3) / total**2
    way = goal - start
    return (
        start + way * u + 4 * bump * u * (1 - u),
        way * u1 + 4 * bump * (1 - 2 * u) * u1,
        way * u2 + 4 * bump * ((1 - 2 * u) * u2 - 2 * u1**2),
    )


def joint_motion(
    robot: PlannedRobot,
    plan: GaitPlan,
    phase: Phase,
    courses: Mapping[str, Course],
    start: Rotation,
) -> RobotMotion:
    """Joints that carry the tips along their courses, and the torques by Pinocchio's RNEA.

    Args:
        robot: the gantry.
        plan: whose gravity acts.
        phase: whose tool motion and forces count.
        courses: of every finger.
        start: orientation of the tool at which the hinges are at zero.
    """
    tool = phase.tool
    turned, omega = tool.rotation.as_matrix(), tool.angular_velocity
    hinges = _hinges(tool, start)
    columns = []
    for name in FINGERS:
        at, speed, surge = ((turned @ part[:, :, None])[:, :, 0] for part in courses[name])
        slides = (
            tool.position + at,
            tool.linear_velocity + np.cross(omega, at) + speed,
            tool.linear_acceleration
            + np.cross(tool.angular_acceleration, at)
            + np.cross(omega, np.cross(omega, at))
            + 2.0 * np.cross(omega, speed)
            + surge,
        )
        columns.append([np.hstack(pair) for pair in zip(slides, hinges, strict=True)])
    ordered = [np.hstack(parts) for parts in zip(*columns, strict=True)]
    q, v, a = (part[:, _order(robot)] for part in ordered)
    return RobotMotion(q, v, a, torques(robot, plan, phase, q, v, a))


def _order(robot: PlannedRobot) -> list[int]:
    ours = [f"{n}_{k}_{x}_joint" for n in FINGERS for k in ("slide", "hinge") for x in "xyz"]
    return [ours.index(name) for name in robot.joint_names]


def _hinges(tool: ToolMotion, start: Rotation) -> Course:
    """Euler angles of the turn since ``start`` and their derivatives: w = E(angles) rates."""
    angles = (tool.rotation * start.inv()).as_euler("XYZ")
    (ca, cb, _), (sa, sb, _) = np.cos(angles).T, np.sin(angles).T
    one, zero = np.ones_like(ca), np.zeros_like(ca)
    jacobian = np.stack(
        ([one, zero, zero], [zero, ca, sa], [sb, -sa * cb, ca * cb])
    ).transpose(2, 1, 0)  # fmt: skip
    rates = np.linalg.solve(jacobian, tool.angular_velocity[:, :, None])[:, :, 0]
    a1, b1 = rates[:, 0], rates[:, 1]
    change = np.stack(
        (
            [zero, zero, zero],
            [zero, -sa * a1, ca * a1],
            [cb * b1, sa * sb * b1 - ca * cb * a1, -sa * cb * a1 - ca * sb * b1],
        )
    ).transpose(2, 1, 0)
    missing = tool.angular_acceleration[:, :, None] - change @ rates[:, :, None]
    return angles, rates, np.linalg.solve(jacobian, missing)[:, :, 0]


def torques(
    robot: PlannedRobot, plan: GaitPlan, phase: Phase, q: np.ndarray, v: np.ndarray, a: np.ndarray
) -> np.ndarray:
    """(N, n): RNEA with the tool's push, -f, on each touching fingertip as an external force."""
    model = pin.buildModelFromXML(robot.urdf)
    model.gravity.linear = np.array(plan.gravity)
    data = model.createData()
    tau = np.empty_like(q)
    points = {n: c.world_point(phase.tool) for n, c in phase.contacts.items() if not c.is_pivot}
    for k in range(len(q)):
        pin.forwardKinematics(model, data, q[k])
        external = [pin.Force.Zero() for _ in range(model.njoints)]
        for name, point in points.items():
            frame = model.getFrameId(robot.fingers[name].tip_frame, pin.FrameType.BODY)
            joint = model.frames[frame].parentJoint
            push = -phase.contacts[name].force[k]
            wrench = pin.Force(push, np.cross(point[k], push))
            external[joint] = data.oMi[joint].actInv(wrench)
        tau[k] = pin.rnea(model, data, q[k], v[k], a[k], external)
    return tau
