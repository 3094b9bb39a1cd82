"""Laws behind the checks of the arm-hand: spin is free, sampling errors are known, Coal agrees."""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.certification import LIMITS
from pivotgait.certification.hand_clearance import check_hand_clearance
from pivotgait.certification.holds import Holds
from pivotgait.certification.joint_sampling import check_joint_sampling
from pivotgait.certification.poses import with_middles
from pivotgait.certification.rigid_robot import RigidRobot, rigid_robot
from pivotgait.certification.solid import RigidTool, rigid_tool
from pivotgait.certification.surroundings import Surroundings
from pivotgait.certification.tips import TipMotion, tip_motions
from pivotgait.plans import GaitPlan, Phase, PlannedFinger, RobotMotion, ToolMotion
from tests.certification.gantry import FINGERS, RADIUS

LIFT, APPROACH, ADDITION, REMOVAL, RELOCATION, LAST = range(6)


def turning_tip(phase: Phase, name: str, axis: np.ndarray, angle: float) -> TipMotion:
    """A held tip that turns about ``axis`` (tool frame) through its centre, by up to ``angle``."""
    tool, contact = phase.tool, phase.contacts[name]
    rotation, t = tool.rotation.as_matrix(), phase.time[:, None]
    course, rate, surge = angle * np.sin(t), angle * np.cos(t), -angle * np.sin(t)
    at = rotation @ (contact.point - RADIUS * contact.normal)
    around = rotation @ axis
    omega, sigma = tool.angular_velocity, tool.angular_acceleration
    return TipMotion(
        position=tool.position + at,
        rotation=rotation @ Rotation.from_rotvec(course * axis).as_matrix(),
        velocity=tool.linear_velocity + np.cross(omega, at),
        angular_velocity=omega + rate * around,
        acceleration=tool.linear_acceleration
        + np.cross(sigma, at)
        + np.cross(omega, np.cross(omega, at)),
        angular_acceleration=sigma + surge * around + np.cross(omega, rate * around),
    )


def holds(phase: Phase, name: str, tip: TipMotion) -> dict[str, float]:
    alone = replace(phase, contacts={name: phase.contacts[name]})
    checker = Holds({name: PlannedFinger("tip", RADIUS)})
    return {found.what: found.value for found in checker.check(alone, {name: tip})}


@pytest.mark.parametrize("place", [LIFT, REMOVAL])
@pytest.mark.parametrize("angle", [0.0, 0.7, -3.0])
def test_spin_about_the_normal_is_free(robot_plan: GaitPlan, place: int, angle: float) -> None:
    phase = robot_plan.phases[place]
    tip = turning_tip(phase, "thumb", phase.contacts["thumb"].normal, angle)
    assert max(holds(phase, "thumb", tip).values()) < 1e-12


@pytest.mark.parametrize("angle", [1e-3, 0.3])
def test_rolling_is_measured(robot_plan: GaitPlan, angle: float) -> None:
    phase = robot_plan.phases[LIFT]
    tip = turning_tip(phase, "thumb", np.array([1.0, 0.0, 0.0]), angle)
    found, largest = holds(phase, "thumb", tip), angle * np.sin(phase.time[-1])
    assert found["tip_rolling_rad"] == pytest.approx(largest, rel=1e-9)
    assert found["tip_slip_m"] == pytest.approx(2.0 * RADIUS * np.sin(0.5 * largest), rel=1e-9)
    assert found["tip_velocity_m_s"] == pytest.approx(RADIUS * angle, rel=1e-9)
    assert found["tip_contact_m"] < 1e-12


def excesses(time, q, v, a, tool: ToolMotion | None = None) -> dict[str, float]:
    """Excess of one joint while the tool rests or moves as given."""
    zero = np.zeros((len(time), 3))
    if tool is None:
        upright = np.tile([0.0, 0.0, 0.0, 1.0], (len(time), 1))
        tool = ToolMotion(zero, upright, zero, zero, zero, zero)
    phase = Phase("00_transfer", "transfer", "", time, tool, {})
    motion = RobotMotion(q[:, None], v[:, None], a[:, None], 0.0 * q[:, None])
    return {each.what: each.value for each in check_joint_sampling(phase, motion, ["J1"])}


def passes(*motion) -> bool:
    return all(LIMITS[what].holds(value) for what, value in excesses(*motion).items())


def polynomial(samples: int, coefficients: list[float], uneven: bool = False):
    time = np.linspace(0.0, 1.0, samples) ** (1.3 if uneven else 1.0)
    course = np.polynomial.Polynomial(coefficients)
    return time, course(time), course.deriv()(time), course.deriv(2)(time)


QUINTIC = [0.0, 0.0, 0.0, 10.0, -15.0, 6.0]


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize("samples", [9, 40, 600])
@pytest.mark.parametrize("coefficients", [[1.0], [1.0, -2.0, 3.0, -1.5], QUINTIC])
def test_polynomials_pass(samples: int, coefficients: list[float], uneven: bool) -> None:
    assert passes(*polynomial(samples, coefficients, uneven))


@pytest.mark.parametrize("ramp", [0.1, 0.123, 0.25, 0.5])
@pytest.mark.parametrize("samples", [21, 64])
def test_jumps_of_acceleration_pass(samples: int, ramp: float) -> None:
    time = np.linspace(0.0, 1.0, samples)
    rate = np.clip(np.minimum(time, 1.0 - time) / ramp, 0.0, 1.0)
    surge = np.where(time < ramp, 1.0 / ramp, np.where(time > 1.0 - ramp, -1.0 / ramp, 0.0))
    late = (1.0 - ramp) - 0.5 * (1.0 - time) ** 2 / ramp
    early = np.where(time < ramp, 0.5 * time**2 / ramp, time - 0.5 * ramp)
    assert passes(time, np.where(time > 1.0 - ramp, late, early), rate, surge)


@pytest.mark.parametrize("samples", [40, 600])
def test_wrong_speed_and_acceleration_are_seen(samples: int) -> None:
    time, q, v, a = polynomial(samples, QUINTIC)
    assert excesses(time, q, 1.01 * v, a)["joint_step_excess"] > 1e-6
    assert excesses(time, q, v, 1.1 * a)["joint_rate_excess"] > 1e-6
    assert excesses(time, q, v, a + 0.5)["joint_rate_excess"] > 1e-6
    assert excesses(time, -q, v, a)["joint_step_excess"] > 1e-4


def test_joints_that_hold_a_tool_of_euler_steps_pass_only_with_it(robot_plan: GaitPlan) -> None:
    phase = robot_plan.phases[REMOVAL]
    q, v, a = (getattr(phase.robot, name)[:, 0] for name in ("q", "v", "a"))
    assert passes(phase.time, q, v, a, phase.tool)
    assert not passes(phase.time, q, v, a)
    assert not passes(phase.time, q, 1.1 * v, a, phase.tool)


@pytest.fixture(scope="module")
def rigid(robot_plan: GaitPlan) -> RigidRobot:
    return rigid_robot(robot_plan.robot)


@pytest.fixture(scope="module")
def tool(robot_plan: GaitPlan) -> RigidTool:
    return rigid_tool(robot_plan.tool)


def brute_force(plan: GaitPlan, rigid: RigidRobot, tool: RigidTool, pose) -> tuple[float, dict]:
    """Every pair by one fresh call of Coal each; the table by the shapes' supports."""
    q, position, quaternion = pose
    data, placed = rigid.model.createData(), rigid.shapes.createData()
    pin.updateGeometryPlacements(rigid.model, data, rigid.shapes, placed, q)
    turn = Rotation.from_quat(quaternion).as_matrix()
    body = pin.SE3(turn, position)
    solids = [(s.geometry, body * pin.SE3(s.rotation, s.translation)) for s in tool.solids]
    links = list(zip(rigid.shapes.geometryObjects, placed.oMg, strict=True))
    tips = {rigid.shapes.geometryObjects[i].name: name for name, i in rigid.tip_shapes.items()}
    hand, to_tool = [], dict.fromkeys(tips.values(), np.inf)
    for i, (one, at_one) in enumerate(links):
        for geometry, place in solids:
            distance = fresh(one.geometry, at_one, geometry, place)
            if one.name in tips:
                to_tool[tips[one.name]] = min(to_tool[tips[one.name]], distance)
            else:
                hand.append(distance)
        if one.parentJoint > 0:
            hand.append(at_one.translation[2] - lowest(one.geometry, at_one) - plan.table_height)
        for other, at_other in links[i + 1 :]:
            joints = (one.parentJoint, other.parentJoint)
            if joints[0] != joints[1]:  # no two shapes of the gantry are on neighbouring bodies
                hand.append(fresh(one.geometry, at_one, other.geometry, at_other))
    return min(hand), to_tool


def fresh(one, at_one: pin.SE3, other, at_other: pin.SE3) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    places = [coal.Transform3s(at.rotation, at.translation) for at in (at_one, at_other)]
    return float(coal.distance(one, places[0], other, places[1], request, result))


def lowest(shape, at: pin.SE3) -> float:
    if isinstance(shape, coal.Sphere):
        return shape.radius
    return shape.radius + shape.halfLength * abs(at.rotation[2, 2])


def test_distances_agree_with_every_pair_alone(
    robot_plan: GaitPlan, rigid: RigidRobot, tool: RigidTool
) -> None:
    rng = np.random.default_rng(8)
    world = Surroundings(robot_plan, robot_plan.robot, rigid, tool)
    phase = robot_plan.phases[RELOCATION]
    for k in range(0, 41, 2):
        q = phase.robot.q[k] + rng.normal(size=rigid.model.nq) * 0.02
        quaternion = Rotation.random(rng=rng).as_quat()
        pose = (q, phase.tool.position[k] + rng.normal(size=3) * 0.02, quaternion)
        hand, to_tool = brute_force(robot_plan, rigid, tool, pose)
        distance, links = world.measure(*pose)
        assert distance == pytest.approx(hand, abs=1e-6)
        assert " - " in links
        for name in FINGERS:
            assert world.tip_to_tool(name) == pytest.approx(to_tool[name], abs=1e-6)


def test_middles_of_cubic_motions_are_exact(robot_plan: GaitPlan) -> None:
    time, q, v, a = polynomial(11, [1.0, -2.0, 3.0, -1.5], uneven=True)
    phase = robot_plan.phases[RELOCATION]
    tool = ToolMotion(*(getattr(phase.tool, f)[:11] for f in phase.tool.__dataclass_fields__))
    motion = RobotMotion(*(each[:, None] for each in (q, v, a, a)))
    poses = with_middles(replace(phase, time=time, tool=tool), motion)
    between = 0.5 * (time[1:] + time[:-1])
    course = np.polynomial.Polynomial([1.0, -2.0, 3.0, -1.5])
    assert np.allclose(poses.q[1::2, 0], course(between), rtol=0.0, atol=1e-14)
    assert np.array_equal(poses.q[::2, 0], q)


def test_collision_between_two_samples_is_found(robot_plan: GaitPlan) -> None:
    """The idle finger darts through its neighbour and is back before the next sample."""
    phase = robot_plan.phases[LIFT]
    column = robot_plan.robot.joint_names.index("middle_slide_x_joint")
    v = np.array(phase.robot.v)
    # A cubic with rates +s and -s at its ends has its middle h s / 4 away.
    h = phase.time[1] - phase.time[0]
    v[20, column], v[21, column] = -0.015 * 4.0 / h, 0.015 * 4.0 / h
    found = clearance_of(robot_plan, replace(phase, robot=replace(phase.robot, v=v)))
    assert found.value < 0.0
    assert found.time_s == pytest.approx(0.5 * (phase.time[20] + phase.time[21]))
    assert clearance_of(robot_plan, phase).value > 1e-3


def clearance_of(plan: GaitPlan, phase: Phase):
    rigid = rigid_robot(plan.robot)
    world = Surroundings(plan, plan.robot, rigid, rigid_tool(plan.tool))
    tips = tip_motions(rigid, phase.robot)
    found = check_hand_clearance(phase, phase.robot, tips, world, 1e-3)
    return next(each for each in found if each.what == "hand_clearance_m")
