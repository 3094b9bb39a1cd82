"""Every engine and Pinocchio see one arm-hand, and the engines' own habits are off."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.models import load_scene
from pivotgait.models.scene import Scene
from pivotgait.plans import PlannedFinger
from pivotgait.validation import Simulator, SimulatorOptions, World, make_simulator
from pivotgait.validation.link_pairs import quiet_pairs

HIGH = np.array([0.0, 0.0, 3.0])
Dynamics = tuple[np.ndarray, np.ndarray]
"""Mass matrix (nv, nv) and inverse dynamics (nv,), in the order of q."""


@pytest.fixture(scope="module", params=["knife", "knife_allegro"])
def scene(request: pytest.FixtureRequest) -> Scene:
    return load_scene(request.param)


@pytest.fixture
def simulator(name: str, scene: Scene) -> Iterator[Simulator]:
    robot = scene.robot
    world = World(
        robot_urdf=robot.urdf,
        joint_names=robot.joint_names,
        fingers={n: PlannedFinger(f.tip_frame, f.tip_radius) for n, f in robot.fingers.items()},
        never_touch=robot.never_touch,
        tool_urdf=scene.tool.urdf,
        pivot_in_tool=scene.tool.pivot_in_tool,
        tip_radius=scene.tool.tip_radius,
        finger_friction=dict.fromkeys(robot.fingers, 0.8),
        table_friction=0.4,
        table_height=-5.0,
        gravity=scene.gravity,
        joint_friction=np.zeros(robot.nv),
    )
    with make_simulator(name, world, SimulatorOptions()) as simulator:
        yield simulator


def in_bullet(simulator: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Dynamics:
    import pybullet

    client, robot = {"physicsClientId": simulator.client}, simulator.robot
    infos = [
        pybullet.getJointInfo(robot, k, **client)
        for k in range(pybullet.getNumJoints(robot, **client))
    ]
    # Bullet's order of coordinates, as columns of q
    order = [simulator.joints.index(k[0]) for k in infos if k[2] != pybullet.JOINT_FIXED]
    back = np.argsort(order)
    mass = np.array(pybullet.calculateMassMatrix(robot, q[order].tolist(), **client))
    given = [each[order].tolist() for each in (q, v, a)]
    torque = np.array(pybullet.calculateInverseDynamics(robot, *given, **client))
    return mass[np.ix_(back, back)], torque[back]


def in_mujoco(simulator: Any, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> Dynamics:
    import mujoco

    simulator.reset(q, v, HIGH, np.eye(3))
    model, data, dofs = simulator.model, simulator.data, simulator.dofs
    data.qacc[dofs] = a
    mujoco.mj_inverse(model, data)
    assert data.ncon == 0
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    # the inverse of MuJoCo leaves out what passive and constraint forces do
    torque = data.qfrc_inverse + data.qfrc_passive + data.qfrc_constraint
    return mass[np.ix_(dofs, dofs)], torque[dofs]


ENGINES: Mapping[str, Callable[..., Dynamics]] = {"pybullet": in_bullet, "mujoco": in_mujoco}


def posture(scene: Scene, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    robot = scene.robot
    q = robot.home + 0.1 * rng.uniform(-1, 1, robot.nv) * (robot.upper - robot.lower)
    q = np.clip(q, robot.lower + 0.02, robot.upper - 0.02)
    return q, rng.normal(size=robot.nv), rng.normal(size=robot.nv)


@pytest.mark.parametrize("seed", [0, 1])
def test_mass_matrix_and_inverse_dynamics(
    name: str, scene: Scene, simulator: Simulator, seed: int
) -> None:
    model = scene.robot.model.copy()
    model.gravity = pin.Motion(np.array(scene.gravity), np.zeros(3))
    data, (q, v, a) = model.createData(), posture(scene, seed)
    mass, torque = ENGINES[name](simulator, q, v, a)
    ours = pin.crba(model, data, q)
    # of entries up to 40 kg m^2 and torques up to 80 N: rounding of sums over the tree
    np.testing.assert_allclose(mass, np.triu(ours) + np.triu(ours, 1).T, atol=1e-9)
    np.testing.assert_allclose(torque, pin.rnea(model, data, q, v, a), atol=1e-8)


@pytest.mark.parametrize("seed", [0, 1])
def test_torques_accelerate_as_in_pinocchio(scene: Scene, simulator: Simulator, seed: int) -> None:
    """No motor, no damping, no clamp, joints by name."""
    model = scene.robot.model.copy()
    model.gravity = pin.Motion(np.array(scene.gravity), np.zeros(3))
    model.damping[:] = 0.0
    data, (q, v, a) = model.createData(), posture(scene, seed)
    torque = pin.rnea(model, data, q, v, a)
    simulator.reset(q, v, HIGH, np.eye(3))
    simulator.step(torque)
    state = simulator.state()
    assert state.unwanted == ()
    np.testing.assert_allclose((state.v - v) / simulator.step_s, a, atol=1e-6)


def test_the_state_is_what_was_set(scene: Scene, simulator: Simulator) -> None:
    q, v, _ = posture(scene, 3)
    turn = Rotation.from_euler("ZYX", [0.3, 0.2, -1.5]).as_matrix()
    simulator.reset(q, v, HIGH, turn)
    state = simulator.state()
    np.testing.assert_array_equal(state.q, q)
    np.testing.assert_array_equal(state.v, v)
    np.testing.assert_allclose(state.tool_position, HIGH, atol=1e-15)
    np.testing.assert_allclose(state.tool_rotation, turn, atol=1e-12)


def test_quiet_pairs_are_those_the_planner_leaves_out(scene: Scene) -> None:
    robot = scene.robot
    quiet = {frozenset(pair) for pair in quiet_pairs(robot.urdf, robot.never_touch).among}
    frames = robot.model.frames
    shapes = robot.collision.geometryObjects
    paired = {
        frozenset(frames[shapes[k].parentFrame].name for k in (pair.first, pair.second))
        for pair in robot.collision.collisionPairs
    }
    assert paired
    assert not paired & quiet
    links = {frames[shape.parentFrame].name for shape in shapes}
    every = {frozenset((a, b)) for a in links for b in links if a != b}
    assert {pair for pair in every if pair not in quiet} == paired
