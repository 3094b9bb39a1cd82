"""Lifting off: the table lets go first, the tool goes straight up, the fingers bear it all."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InfeasibleError
from pivotgait.forces import allocate
from pivotgait.models import Scene, load_scene
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.carrying import carry
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.relocation import resting_tool
from pivotgait.phases.transfer import RISING, UNLOADING, TransferOptions, plan_transfer
from pivotgait.plans import PIVOT, Phase, ToolMotion

OPTIONS = TransferOptions(duration_s=2.0, steps=60, rise_m=0.04)
NAME = "00_transfer"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("screwdriver")


def held(scene: Scene, roll_deg: float = 25.0) -> tuple[Setting, Grasp]:
    """The screwdriver at rest between thumb and middle finger; 21 deg of roll is upright."""
    setting = Setting.of(scene)
    lift = scene.gaits["default"][0].to.model_copy(update={"roll_deg": roll_deg})
    rotation = scene.lift_rotation(lift)
    fingers = [scene.contacts[name] for name in ("thumb_top", "middle_below")]
    problem = allocation_problem(setting, resting_tool(setting, rotation, 1), fingers)
    force = allocate(problem).require().force[0]
    forces = dict(zip((PIVOT, "thumb", "middle"), force, strict=True))
    by_finger = {each.finger: each for each in fingers}
    return setting, Grasp(rotation, by_finger, MappingProxyType(forces))


@pytest.fixture(scope="module")
def phase(scene: Scene) -> Phase:
    return plan_transfer(*held(scene), OPTIONS, name=NAME)[0]


def test_the_tool_rises_straight_up_without_turning(phase: Phase) -> None:
    way = phase.tool.position - phase.tool.position[0]
    np.testing.assert_array_equal(way[:, :2], 0.0)
    assert way[-1, 2] == pytest.approx(OPTIONS.rise_m)
    assert np.all(np.diff(way[:, 2]) >= 0.0)
    assert phase.reorientation_deg == pytest.approx(0.0, abs=1e-9)
    rates = np.gradient(phase.tool.position[:, 2], phase.time)
    np.testing.assert_allclose(rates, phase.tool.linear_velocity[:, 2], atol=2e-3)


def test_the_table_has_let_go_before_the_tool_rises_and_it_hangs_at_the_end(phase: Phase) -> None:
    pushed = np.linalg.norm(phase.contacts[PIVOT].force, axis=1) > 0.0
    raised = phase.tool.position[:, 2] > phase.tool.position[0, 2] + 1e-12
    assert not np.any(pushed & raised)
    assert phase.time[pushed].max() <= UNLOADING * OPTIONS.duration_s
    hanging = phase.time >= (UNLOADING + RISING) * OPTIONS.duration_s
    np.testing.assert_allclose(phase.tool.linear_velocity[hanging], 0.0, atol=1e-12)


def test_hanging_fingers_bear_the_weight(scene: Scene, phase: Phase) -> None:
    total = sum(phase.contacts[name].force[-1] for name in ("thumb", "middle"))
    np.testing.assert_allclose(total, -scene.tool.mass * scene.gravity, atol=1e-8)


def test_forces_start_from_those_that_hold_and_the_reserve_is_left(
    scene: Scene, phase: Phase
) -> None:
    _, grasp = held(scene)
    usable = 1.0 - scene.allocation.friction_reserve
    for name, force in grasp.forces.items():
        np.testing.assert_allclose(phase.contacts[name].force[0], force, atol=1e-9)
    for name in ("thumb", "middle"):
        track = phase.contacts[name]
        normal = track.world_normal(phase.tool)
        pressing = np.sum(track.force * normal, axis=1)
        across = np.linalg.norm(track.force - pressing[:, None] * normal, axis=1)
        assert track.moment is not None
        spin = track.moment * track.friction / track.torsion
        used = np.hypot(across, spin)[1:] / (track.friction * pressing[1:])
        assert used.max() <= usable + 1e-8


def test_a_line_out_of_the_vertical_plane_cannot_be_borne(scene: Scene) -> None:
    setting, grasp = held(scene, roll_deg=5.0)
    with pytest.raises(InfeasibleError, match="about the line through them with") as caught:
        plan_transfer(setting, grasp, OPTIONS, name=NAME)
    assert caught.value.where == NAME


def test_the_hand_is_carried_as_one_body(scene: Scene, phase: Phase) -> None:
    robot = scene.robot
    assert robot is not None
    motion = carry(robot, phase.time, phase.tool, robot.home)
    fingers = [k for k in range(robot.nv) if k not in robot.palm_columns]
    np.testing.assert_array_equal(motion.q[:, fingers], np.tile(robot.home[fingers], (61, 1)))
    palms = [_palm(robot, q) for q in motion.q]
    way = [palm.translation - palms[0].translation for palm in palms]
    np.testing.assert_allclose(way, phase.tool.position - phase.tool.position[0], atol=1e-10)
    turns = [pin.log3(palms[0].rotation.T @ palm.rotation) for palm in palms]
    np.testing.assert_allclose(turns, 0.0, atol=1e-10)
    np.testing.assert_allclose(np.gradient(motion.q, phase.time, axis=0), motion.v, atol=5e-3)
    np.testing.assert_allclose(np.gradient(motion.v, phase.time, axis=0), motion.a, atol=5e-2)


def test_the_palm_follows_a_turning_tool(scene: Scene) -> None:
    """Velocities and accelerations are the derivatives of the positions, on a lift too."""
    from pivotgait.phases.lift import LiftOptions, lift_motion

    robot, setting = scene.robot, Setting.of(scene)
    assert robot is not None
    target = scene.lift_rotation(scene.gaits["default"][0].to.model_copy(update={"pitch_deg": 9.0}))
    options = LiftOptions(1.0, 200)
    time, tool = lift_motion(setting, scene.rest_rotation, target, options)
    assert isinstance(tool, ToolMotion)
    motion = carry(robot, time, tool, robot.home)
    np.testing.assert_allclose(np.gradient(motion.q, time, axis=0), motion.v, atol=5e-3)
    np.testing.assert_allclose(np.gradient(motion.v, time, axis=0), motion.a, atol=5e-2)


def _palm(robot: object, q: np.ndarray) -> pin.SE3:
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, np.array(q))
    return pin.SE3(pin.updateFramePlacement(robot.model, data, robot.palm_frame_id))
