"""An arm and a hand become one URDF: the same dynamics as the parts, in Pinocchio and Bullet."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin
import pybullet
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.models import Robot, export_scene, load_scene, parse_scene
from pivotgait.models.robot_loading import build_robot
from pivotgait.models.urdf import check_urdf
from tests.models.robot_cases import BASE, HAND_PATH, POSE, RING, UR5_PATH, config, small, text_of


@pytest.fixture(scope="module")
def robot() -> Robot:
    return build_robot(text_of(), config(), where="robot")


def bullet_of(path: Path) -> Iterator[tuple[int, int]]:
    client = pybullet.connect(pybullet.DIRECT)
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
    yield client, body
    pybullet.disconnect(client)


@pytest.fixture(scope="module")
def bullet(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[int, int]]:
    path = tmp_path_factory.mktemp("bullet") / "robot.urdf"
    path.write_text(robot.urdf)
    yield from bullet_of(path)


def mass_matrix(model: pin.Model, q: np.ndarray) -> np.ndarray:
    upper = np.triu(pin.crba(model, model.createData(), q))
    return upper + np.triu(upper, 1).T


def test_the_joined_robot_moves_as_its_parts(robot: Robot) -> None:
    """M, tips and masses equal those of pinocchio.appendModel of the two files."""
    arm, hand = (pin.buildModelFromUrdf(str(path)) for path in (UR5_PATH, HAND_PATH))
    locked = pin.neutral(hand)
    for name, value in RING.items():
        locked[hand.joints[hand.getJointId(name)].idx_q] = value
    hand = pin.buildReducedModel(hand, [hand.getJointId(name) for name in RING], locked)
    turn = Rotation.from_euler("xyz", POSE["rpy_deg"], degrees=True).as_matrix()
    pose = pin.SE3(turn, np.array(POSE["position_m"]))
    both = pin.appendModel(arm, hand, arm.getFrameId("tool0", pin.FrameType.BODY), pose)
    assert robot.joint_names == tuple(both.names)[1:]
    yaw = Rotation.from_euler("z", BASE["yaw_deg"], degrees=True).as_matrix()
    base = pin.SE3(yaw, np.array(BASE["position_m"]))
    data, ours, rng = both.createData(), robot.model.createData(), np.random.default_rng(0)
    for _ in range(20):
        q = rng.uniform(robot.lower, robot.upper)
        expected = mass_matrix(both, q)
        np.testing.assert_allclose(mass_matrix(robot.model, q), expected, rtol=0, atol=1e-9)
        pin.framesForwardKinematics(both, data, q)
        pin.framesForwardKinematics(robot.model, ours, q)
        for finger in robot.fingers.values():
            frame = both.getFrameId(finger.tip_frame, pin.FrameType.BODY)
            tip = ours.oMf[finger.tip_frame_id].homogeneous
            np.testing.assert_allclose(tip, (base * data.oMf[frame]).homogeneous, atol=1e-9)
    moving = pin.computeTotalMass(robot.model)
    assert moving == pytest.approx(pin.computeTotalMass(both), abs=1e-9)
    placed = sum(body.mass for body in robot.model.inertias)
    assert placed == pytest.approx(20.9939 + 0.9549, abs=1e-9), "with the parts that stand still"


def test_pinocchio_and_bullet_read_the_joined_text_alike(
    robot: Robot, bullet: tuple[int, int]
) -> None:
    client, body = bullet
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, i, physicsClientId=client) for i in range(count)]
    moving = [info for info in infos if info[2] != pybullet.JOINT_FIXED]
    # Bullet keeps the text's order of joints, Pinocchio sorts siblings by name.
    order = [robot.joint_names.index(info[1].decode()) for info in moving]
    assert sorted(order) == list(range(robot.nv))
    frames = [robot.model.getFrameId(info[12].decode(), pin.FrameType.BODY) for info in infos]
    data, rng = robot.model.createData(), np.random.default_rng(1)
    for _ in range(20):
        q = rng.uniform(robot.lower, robot.upper)
        v, a = rng.uniform(-2, 2, robot.nv), rng.uniform(-5, 5, robot.nv)
        theirs = [each[order].tolist() for each in (q, v, a)]
        other = pybullet.calculateMassMatrix(body, theirs[0], physicsClientId=client)
        expected = mass_matrix(robot.model, q)[np.ix_(order, order)]
        np.testing.assert_allclose(np.array(other), expected, rtol=0, atol=1e-9)
        pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
        other = pybullet.calculateInverseDynamics(body, *theirs, physicsClientId=client)
        effort = pin.rnea(robot.model, data, q, v, a)[order]
        np.testing.assert_allclose(other, effort, rtol=0, atol=1e-7)
        for info, value in zip(moving, theirs[0], strict=True):
            pybullet.resetJointState(body, info[0], value, physicsClientId=client)
        states = pybullet.getLinkStates(
            body, list(range(count)), computeForwardKinematics=True, physicsClientId=client
        )
        pin.framesForwardKinematics(robot.model, data, q)
        for state, frame in zip(states, frames, strict=True):
            pose = data.oMf[frame]
            np.testing.assert_allclose(state[4], pose.translation, rtol=0, atol=1e-6)
            turn = Rotation.from_quat(state[5]).as_matrix()
            np.testing.assert_allclose(turn, pose.rotation, rtol=0, atol=1e-6)


def test_in_every_posture_the_primitives_hold_the_meshes(robot: Robot) -> None:
    arm = pin.buildModelFromUrdf(str(UR5_PATH))
    folder = str(UR5_PATH.parents[4])
    kind = pin.GeometryType.COLLISION
    meshes = pin.buildGeomFromUrdf(arm, str(UR5_PATH), kind, package_dirs=[folder])
    shapes = {each.name: each for each in robot.collision.geometryObjects}
    yaw = Rotation.from_euler("z", BASE["yaw_deg"], degrees=True).as_matrix()
    base = pin.SE3(yaw, np.array(BASE["position_m"]))
    arm_data, data = arm.createData(), robot.model.createData()
    drawn = [each for each in meshes.geometryObjects if each.meshPath.endswith(".stl")]
    assert len(drawn) == 7
    rng = np.random.default_rng(2)
    for _ in range(50):
        q = rng.uniform(robot.lower, robot.upper)
        pin.forwardKinematics(arm, arm_data, q[:6])
        pin.forwardKinematics(robot.model, data, q)
        for mesh in drawn:
            box = shapes[mesh.name]
            from_box = data.oMi[box.parentJoint] * box.placement
            seen = from_box.actInv(base * arm_data.oMi[mesh.parentJoint] * mesh.placement)
            points = np.array(mesh.geometry.vertices()) @ seen.rotation.T + seen.translation
            assert np.all(np.abs(points) <= box.geometry.halfSide), mesh.name


def test_no_engine_drops_a_shape(robot: Robot, bullet: tuple[int, int]) -> None:
    client, body = bullet
    shapes = check_urdf(robot.urdf, where="robot").collisions
    assert robot.collision.ngeoms == len(shapes) == 8 + 21
    links = range(-1, pybullet.getNumJoints(body, physicsClientId=client))
    counted = [len(pybullet.getCollisionShapeData(body, i, physicsClientId=client)) for i in links]
    assert sum(counted) == len(shapes)
    kinds = sorted(type(each.geometry).__name__.lower() for each in robot.collision.geometryObjects)
    assert kinds == sorted(shape.kind for shape in shapes)


def test_the_text_is_self_contained_and_always_the_same(robot: Robot) -> None:
    text = robot.urdf
    summary = check_urdf(text, where="robot")
    assert (summary.version, summary.root) == ("1.1", "world_"), "the arm has a link 'world'"
    assert "<mesh" not in text
    assert "package:" not in text
    assert max(map(len, text.splitlines())) < 200
    assert max(line.count("<") for line in text.splitlines()) == 1
    assert all("<mass" in link or 'name="world_"' in link for link in text.split("<link ")[1:]), (
        "without <inertial> Bullet would add 1 kg"
    )
    assert text == text_of()


def test_names_change_only_where_arm_and_hand_share_them(tmp_path: Path) -> None:
    summary = check_urdf(small(tmp_path), where="robot")
    assert list(summary.links) == ["world", "base", "palm", "hand_palm", "slider"]
    assert list(summary.joints) == ["fix", "turn", "hand_turn", "mount"]
    assert [shape.name for shape in summary.collisions] == ["pad_0", "hand_pad_0"]
    assert (summary.joints["mount"].parent, summary.joints["mount"].child) == ("palm", "hand_palm")
    assert (summary.joints["hand_turn"].parent, summary.name) == ("hand_palm", "arm_hand")
    assert summary.mass == 2.5


@pytest.mark.parametrize(("joint", "value"), [("turn", 1.3), ("turn", -1), ("hand_turn", 0.07)])
def test_a_locked_joint_stands_where_it_is_told(tmp_path: Path, joint: str, value: float) -> None:
    free, locked = (
        pin.buildModelFromXML(small(tmp_path, fixed=fixed)) for fixed in ({}, {joint: value})
    )
    assert (free.nq, locked.nq) == (2, 1)
    q = np.array([0.4, 0.03])
    q[free.getJointId(joint) - 1] = value
    poses = []
    for model, at in ((free, q), (locked, np.delete(q, free.getJointId(joint) - 1))):
        data = model.createData()
        pin.framesForwardKinematics(model, data, at)
        poses.append(data.oMf[model.getFrameId("slider", pin.FrameType.BODY)].homogeneous)
        assert sum(body.mass for body in model.inertias) == pytest.approx(2.5)
    np.testing.assert_allclose(poses[0], poses[1], rtol=0, atol=1e-14)


def test_the_base_moves_everything(tmp_path: Path) -> None:
    plain, placed = (pin.buildModelFromXML(small(tmp_path, base=base)) for base in ({}, BASE))
    pose = pin.SE3(pin.rpy.rpyToMatrix(0, 0, np.radians(40.0)), np.array(BASE["position_m"]))
    q = np.array([0.3, 0.05])
    found = []
    for model in (plain, placed):
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        found.append(data.oMf[model.getFrameId("slider", pin.FrameType.BODY)])
    np.testing.assert_allclose((pose * found[0]).homogeneous, found[1].homogeneous, atol=1e-14)


def test_every_pair_that_may_meet_is_checked_once(robot: Robot) -> None:
    model, shapes = robot.model, robot.collision
    pairs = [(pair.first, pair.second) for pair in shapes.collisionPairs]
    assert len(set(pairs)) == len(pairs)
    for i in range(shapes.ngeoms):
        for k in range(i + 1, shapes.ngeoms):
            a, b = (shapes.geometryObjects[each].parentJoint for each in (i, k))
            meet = a != b and a not in (model.parents[b],) and b not in (model.parents[a],)
            assert ((i, k) in pairs) == meet
    fixed = [
        g.name for g in shapes.geometryObjects if g.parentJoint == model.getJointId("wrist_3_joint")
    ]
    assert {"wrist_3_link_0", "palm_link_0", "link_9.0_0", "link_11.0_tip_0"} <= set(fixed)
    ignored = config(never_touch=[["palm_link", "link_13.0"]])
    fewer = build_robot(robot.urdf, ignored, where="robot")
    assert len(fewer.collision.collisionPairs) == len(pairs) - 1
    assert fewer.never_touch == (("palm_link", "link_13.0"),)


def test_the_scene_of_the_allegro_hand() -> None:
    scene = load_scene("knife_allegro")
    robot = scene.robot
    assert robot is not None
    assert robot.nv == 6 + 12
    assert set(robot.fingers) == {"thumb", "index", "middle"}
    assert [robot.joint_names[i] for i in robot.palm_columns] == [
        "shoulder_pan_joint",
        "shoulder_lift_joint",
        "elbow_joint",
        "wrist_1_joint",
        "wrist_2_joint",
        "wrist_3_joint",
    ]
    data, found = robot.model.createData(), robot.collision.createData()
    pin.computeDistances(robot.model, data, robot.collision, found, robot.home)
    assert min(each.min_distance for each in found.distanceResults) > 2e-3, "home is clear"
    pin.framesForwardKinematics(robot.model, data, robot.home)
    handle = (
        scene.rest_position + scene.rest_rotation.as_matrix() @ scene.contacts["thumb_spine"].point
    )
    for name in ("thumb", "index"):
        tip = data.oMf[robot.fingers[name].tip_frame_id].translation
        assert np.linalg.norm(tip - handle) < 0.1, "home is about the handle"
    again = parse_scene(export_scene("knife_allegro")).robot
    assert again is not None
    assert again.urdf == robot.urdf
