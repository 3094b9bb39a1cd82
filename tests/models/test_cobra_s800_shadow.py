"""The arm with the hand: published kinematics, and one dynamics in Pinocchio and Bullet."""

import math
import re
from collections.abc import Iterator
from itertools import pairwise

import coal
import numpy as np
import pinocchio as pin
import pybullet
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.models import urdf_root
from pivotgait.models.urdf import read_urdf

FOLDER = urdf_root() / "cobra_s800_shadow"
PATH = FOLDER / "cobra_s800_shadow.urdf"
TURN = 2.0 * math.pi

# name: lower, upper [rad or m], effort [N m or N], velocity [rad/s or m/s]
JOINTS = {
    "J1": (math.radians(-105), math.radians(105), 250, math.radians(386)),
    "J2": (math.radians(-157.5), math.radians(157.5), 100, math.radians(720)),
    "J3": (0.0, 0.21, 343, 1.1),
    "J4": (-TURN, TURN, 20, math.radians(1200)),
    "WRJ2": (-0.523599, 0.174533, 6.2, 2.0),
    "WRJ1": (-0.698132, 0.488692, 2.9, 2.0),
    "FFJ4": (-0.349066, 0.349066, 1.0, 2.0),
    "FFJ3": (-0.261799, 1.570796, 1.0, 2.0),
    "FFJ2": (0.0, 1.570796, 1.0, 2.0),
    "FFJ1": (0.0, 1.570796, 1.0, 2.0),
    "MFJ4": (-0.349066, 0.349066, 1.0, 2.0),
    "MFJ3": (-0.261799, 1.570796, 1.0, 2.0),
    "MFJ2": (0.0, 1.570796, 1.0, 2.0),
    "MFJ1": (0.0, 1.570796, 1.0, 2.0),
    "THJ5": (-1.047198, 1.047198, 3.0, 4.0),
    "THJ4": (0.0, 1.221730, 2.0, 4.0),
    "THJ3": (-0.209440, 0.209440, 1.0, 4.0),
    "THJ2": (-0.698132, 0.698132, 1.0, 2.0),
    "THJ1": (-0.261799, 1.570796, 1.0, 4.0),
}
WRIST = ("WRJ2", "WRJ1")
FINGERS = {
    "fftip": ("FFJ4", "FFJ3", "FFJ2", "FFJ1"),
    "mftip": ("MFJ4", "MFJ3", "MFJ2", "MFJ1"),
    "thtip": ("THJ5", "THJ4", "THJ3", "THJ2", "THJ1"),
}
ANGLES = {
    "Q0": {},
    "Q1": {
        WRIST: (-0.10, 0.20),
        FINGERS["fftip"]: (-0.10, 0.60, 0.80, 0.50),
        FINGERS["mftip"]: (0.05, 0.70, 0.90, 0.60),
        FINGERS["thtip"]: (0.30, 0.90, 0.10, 0.25, 0.35),
    },
    "Q2": {  # a two-finger pinch
        WRIST: (0.0188, -0.2686),
        FINGERS["fftip"]: (-0.3013, 0.9774, 1.045, 0.1665),
        FINGERS["mftip"]: (0.1255, 0.165, 0.3459, 0.0005741),
        FINGERS["thtip"]: (0.03082, 1.08, 0.1604, 0.5839, 0.3069),
    },
}
# (posture, tip): position [m] and pad direction in the palm frame
TIPS = {
    ("Q0", "fftip"): ((0.033, 0.0, 0.191), (0.0, -1.0, 0.0)),
    ("Q0", "mftip"): ((0.011, 0.0, 0.195), (0.0, -1.0, 0.0)),
    ("Q0", "thtip"): ((0.102943, -0.00858, 0.097943), (-0.707107, 0.0, 0.707107)),
    ("Q1", "fftip"): ((0.036293, -0.074649, 0.127819), (-0.094472, 0.323290, -0.941573)),
    ("Q1", "mftip"): ((0.010081, -0.075, 0.117364), (0.040408, 0.588501, -0.807486)),
    ("Q1", "thtip"): ((0.039719, -0.073259, 0.09772), (-0.673972, 0.697813, 0.242527)),
    ("Q2", "fftip"): ((0.032758, -0.08099, 0.094223), (-0.241855, 0.579491, -0.778265)),
    ("Q2", "mftip"): ((-0.000124, -0.032341, 0.18717), (0.061267, -0.872024, -0.485614)),
    ("Q2", "thtip"): ((0.027538, -0.082467, 0.080974), (-0.606758, 0.754546, 0.250010)),
}
PALMS = {  # palm in the forearm: position [m], quaternion xyzw
    "Q0": ((0.0, -0.01, 0.24701), (0.0, 0.0, 0.0, 1.0)),
    "Q1": ((-0.003394, -0.01, 0.246840), (0.099709, -0.049729, 0.004990, 0.993761)),
    "Q2": ((0.000639, -0.01, 0.247004), (-0.133891, 0.009315, 0.001259, 0.990952)),
}
FLANGES = [  # J1, J2, J3; flange in the arm's base [m]
    ((0.0, 0.0, 0.0), (0.8, 0.0, 0.387)),
    ((0.5, -0.8, 0.10), (0.731224, 0.092936, 0.287)),
    ((-1.2, 1.9, 0.05), (0.440818, -0.154535, 0.337)),
]


@pytest.fixture(scope="module")
def model() -> pin.Model:
    return pin.buildModelFromUrdf(str(PATH))


@pytest.fixture(scope="module")
def shapes(model: pin.Model) -> pin.GeometryModel:
    """Collision shapes and the pairs of bodies that no joint connects."""
    geometry = pin.buildGeomFromUrdf(model, str(PATH), pin.GeometryType.COLLISION)
    parents = [shape.parentJoint for shape in geometry.geometryObjects]
    for first, a in enumerate(parents):
        for second, b in enumerate(parents[:first]):
            if a != b and model.parents[a] != b and model.parents[b] != a:
                geometry.addCollisionPair(pin.CollisionPair(second, first))
    return geometry


@pytest.fixture
def bullet() -> Iterator[tuple[int, int]]:
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF(str(PATH), useFixedBase=True, flags=flags, physicsClientId=client)
    yield client, body
    pybullet.disconnect(client)


def configuration(model: pin.Model, **values: float) -> np.ndarray:
    q = pin.neutral(model)
    for name, value in values.items():
        assert model.existJointName(name)
        q[model.joints[model.getJointId(name)].idx_q] = value
    return q


def posture(model: pin.Model, name: str, **arm: float) -> np.ndarray:
    values = dict(arm)
    for joints, angles in ANGLES[name].items():
        values.update(zip(joints, angles, strict=True))
    return configuration(model, **values)


def placement(model: pin.Model, q: np.ndarray, child: str, parent: str) -> pin.SE3:
    """Pose of link ``child`` in link ``parent``."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    assert model.existFrame(child)
    assert model.existFrame(parent)
    poses = [data.oMf[model.getFrameId(name)] for name in (parent, child)]
    return poses[0].actInv(poses[1])


def touching(model: pin.Model, shapes: pin.GeometryModel, q: np.ndarray) -> list[tuple[str, str]]:
    data, found = model.createData(), shapes.createData()
    pin.computeCollisions(model, data, shapes, found, q, False)
    names = [shape.name for shape in shapes.geometryObjects]
    pairs = [(names[pair.first], names[pair.second]) for pair in shapes.collisionPairs]
    results = found.collisionResults
    return [pair for pair, hit in zip(pairs, results, strict=True) if hit.isCollision()]


def test_joints_are_the_documented_ones_in_order(model: pin.Model) -> None:
    summary = read_urdf(PATH)
    moving = {n: joint for n, joint in summary.joints.items() if joint.kind != "fixed"}
    assert len(JOINTS) == 19
    assert list(moving) == list(JOINTS) == list(model.names)[1:]
    assert model.nq == model.nv == 19
    for name, joint in moving.items():
        written = (joint.lower, joint.upper, joint.effort, joint.velocity)
        np.testing.assert_allclose(written, JOINTS[name], rtol=0, atol=1e-6, err_msg=name)
    assert moving["J3"].kind == "prismatic"
    assert max(model.damping) <= 1e-3


def test_conventions_that_suit_every_engine(model: pin.Model) -> None:
    summary = read_urdf(PATH)
    names = [frame.name for frame in model.frames]
    assert len(set(names)) == len(names), "a link and a joint must not share a name"
    assert summary.links[summary.root].inertial is None
    for link in summary.links.values():
        if link.inertial is not None:
            np.testing.assert_array_equal(
                link.inertial.inertia, np.diag(np.diag(link.inertial.inertia)), err_msg=link.name
            )
            assert np.diag(link.inertial.inertia).min() >= 1e-8
    assert set(re.findall(r"<inertial>\s*<origin [^>]*rpy=\"([^\"]*)\"", summary.text)) == {"0 0 0"}


def test_a_fingertip_is_a_sphere_about_its_tip_frame() -> None:
    links = read_urdf(PATH).links
    for tip, radius in (("fftip", 0.006), ("mftip", 0.006), ("thtip", 0.0075)):
        (sphere,) = links[tip].collisions
        assert (sphere.kind, sphere.size) == ("sphere", (radius,))
        np.testing.assert_array_equal(sphere.translation, np.zeros(3))


@pytest.mark.parametrize(("name", "tip"), TIPS)
def test_fingertip_in_the_palm(model: pin.Model, name: str, tip: str) -> None:
    position, pad = TIPS[name, tip]
    pose = placement(model, posture(model, name), tip, "palm")
    np.testing.assert_allclose(pose.translation, position, rtol=0, atol=1e-6)
    np.testing.assert_allclose(-pose.rotation[:, 1], pad, rtol=0, atol=1e-5)


@pytest.mark.parametrize("name", PALMS)
def test_palm_in_the_forearm(model: pin.Model, name: str) -> None:
    position, quaternion = PALMS[name]
    pose = placement(model, posture(model, name), "palm", "forearm")
    np.testing.assert_allclose(pose.translation, position, rtol=0, atol=1e-6)
    turn = Rotation.from_quat(quaternion).as_matrix()
    np.testing.assert_allclose(pose.rotation, turn, rtol=0, atol=3e-6)


@pytest.mark.parametrize(("joints", "expected"), FLANGES)
def test_flange_in_the_arm_base(
    model: pin.Model, joints: tuple[float, ...], expected: tuple[float, ...]
) -> None:
    q = configuration(model, J1=joints[0], J2=joints[1], J3=joints[2], J4=0.7)
    pose = placement(model, q, "flange", "arm_base")
    np.testing.assert_allclose(pose.translation, expected, rtol=0, atol=1e-6)
    # z points down and J4 turns about it, so that it takes away from the yaw.
    yaw = Rotation.from_euler("z", joints[0] + joints[1] - 0.7) * Rotation.from_euler("x", math.pi)
    np.testing.assert_allclose(pose.rotation, yaw.as_matrix(), rtol=0, atol=1e-12)


def test_mounting_of_arm_and_hand(model: pin.Model) -> None:
    q = pin.neutral(model)
    base = placement(model, q, "arm_base", "pedestal")
    np.testing.assert_array_equal(base.translation, (0.0, 0.0, 0.17))
    forearm = placement(model, q, "forearm", "flange")
    np.testing.assert_allclose(forearm.translation, (0, 0, 0.046), rtol=0, atol=1e-15)
    tilt = Rotation.from_euler("x", -30, degrees=True).as_matrix()
    np.testing.assert_allclose(forearm.rotation, tilt, rtol=0, atol=1e-12)
    palm = placement(model, q, "palm", "pedestal").rotation
    assert -palm[2, 1] == pytest.approx(-0.5), "the palm looks 30 deg down"


def test_mounting_is_what_the_readme_says() -> None:
    readme = (FOLDER / "README.md").read_text()
    joints = read_urdf(PATH).joints
    (tilt,) = re.findall(r"^\| tilt of the hand \| ([0-9.]+)°", readme, re.MULTILINE)
    turn = Rotation.from_matrix(joints["forearm_mount"].rotation).as_rotvec(degrees=True)
    np.testing.assert_allclose(turn, (-float(tilt), 0.0, 0.0), rtol=0, atol=1e-9)
    (height,) = re.findall(r"^\| height of the pedestal \| ([0-9.]+) m", readme, re.MULTILINE)
    assert joints["pedestal_mount"].translation[2] == float(height)


@pytest.mark.parametrize("tilt", [0.0, -math.pi / 6])
def test_a_closing_hand_reaches_down_to_the_table(tilt: float) -> None:
    text = PATH.read_text()
    written = '<origin xyz="0 0 0.046" rpy="-0.5235987755982988 0 0"/>'
    assert text.count(written) == 1
    text = text.replace("-0.5235987755982988", repr(tilt))
    model = pin.buildModelFromXML(text)
    shapes = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    for stroke, low, high in ((0.0, 0.14, 0.18), (0.12, 0.02, 0.06)):
        q = posture(model, "Q1", J3=stroke)
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        for tip in FINGERS:
            assert low < data.oMf[model.getFrameId(tip)].translation[2] < high
    # Lowered, nothing that moves is in the table.
    table, below = coal.Box(4.0, 4.0, 1.0), coal.Transform3s(np.eye(3), np.array([0, 0, -0.5]))
    checked = 0
    for shape in shapes.geometryObjects:
        if shape.parentJoint > 0:
            pose = data.oMi[shape.parentJoint] * shape.placement
            at = coal.Transform3s(pose.rotation, pose.translation)
            request, result = coal.DistanceRequest(), coal.DistanceResult()
            assert coal.distance(shape.geometry, at, table, below, request, result) > 0.0, shape
            checked += 1
    assert checked == 44


def test_moving_mass_is_what_the_readme_says(model: pin.Model) -> None:
    moving = sum(body.mass for body in list(model.inertias)[1:])
    readme = (FOLDER / "README.md").read_text()
    (said,) = re.findall(r"^\| moving mass \| ([0-9.]+) kg", readme, re.MULTILINE)
    assert moving == pytest.approx(float(said), abs=1e-9)
    assert moving + model.inertias[0].mass == pytest.approx(read_urdf(PATH).mass, abs=1e-9)
    data = model.createData()
    pin.computeSubtreeMasses(model, data)
    wrist = data.mass[model.getJointId("WRJ2")]
    assert wrist == pytest.approx(0.794, abs=1e-9), "all that is distal of the forearm"
    # The quill carries everything below the two arm links.
    q, zero = pin.neutral(model), np.zeros(model.nv)
    held = -pin.rnea(model, data, q, zero, zero)[2] / 9.81
    assert held == pytest.approx(moving - 19.0 - 9.5, abs=1e-9)


def test_no_engine_drops_a_shape(
    model: pin.Model, shapes: pin.GeometryModel, bullet: tuple[int, int]
) -> None:
    summary = read_urdf(PATH)
    visual = pin.buildGeomFromUrdf(model, str(PATH), pin.GeometryType.VISUAL)
    assert shapes.ngeoms == visual.ngeoms == len(summary.collisions) == 46
    kinds = sorted(type(shape.geometry).__name__.lower() for shape in shapes.geometryObjects)
    assert kinds == sorted(shape.kind for shape in summary.collisions)
    client, body = bullet
    links = range(-1, pybullet.getNumJoints(body, physicsClientId=client))
    counted = [len(pybullet.getCollisionShapeData(body, i, physicsClientId=client)) for i in links]
    assert sum(counted) == len(summary.collisions)


def test_pinocchio_and_bullet_agree(model: pin.Model, bullet: tuple[int, int]) -> None:
    client, body = bullet
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, i, physicsClientId=client) for i in range(count)]
    moving = [info[0] for info in infos if info[2] != pybullet.JOINT_FIXED]
    assert [infos[i][1].decode() for i in moving] == list(JOINTS), "one order of joints"
    frames = [model.getFrameId(info[12].decode()) for info in infos]
    data, rng = model.createData(), np.random.default_rng(20)
    for _ in range(100):
        q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        v, a = rng.uniform(-2, 2, model.nv), rng.uniform(-5, 5, model.nv)
        mass = np.triu(pin.crba(model, data, q))
        mass = mass + np.triu(mass, 1).T
        other = pybullet.calculateMassMatrix(body, q.tolist(), physicsClientId=client)
        np.testing.assert_allclose(np.array(other), mass, rtol=0, atol=1e-9)
        effort = pin.rnea(model, data, q, v, a)
        other = pybullet.calculateInverseDynamics(
            body, q.tolist(), v.tolist(), a.tolist(), physicsClientId=client
        )
        np.testing.assert_allclose(other, effort, rtol=0, atol=1e-8)

        pin.framesForwardKinematics(model, data, q)
        for i, value in zip(moving, q, strict=True):
            pybullet.resetJointState(body, i, value, physicsClientId=client)
        states = pybullet.getLinkStates(
            body, list(range(count)), computeForwardKinematics=True, physicsClientId=client
        )
        for state, frame in zip(states, frames, strict=True):
            pose = data.oMf[frame]
            np.testing.assert_allclose(state[4], pose.translation, rtol=0, atol=1e-6)
            turn = Rotation.from_quat(state[5]).as_matrix()
            np.testing.assert_allclose(turn, pose.rotation, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("distal", "tip", "at"),
    [("ffdistal", "fftip", 0.026), ("mfdistal", "mftip", 0.026), ("thdistal", "thtip", 0.0275)],
)
def test_the_tip_sphere_is_outermost_on_the_pad_side(distal: str, tip: str, at: float) -> None:
    links = read_urdf(PATH).links
    (capsule,), (sphere,) = links[distal].collisions, links[tip].collisions
    (thin, length), (radius,) = capsule.size, sphere.size
    ends = capsule.translation + np.outer((-length / 2, length / 2), capsule.rotation[:, 2])
    centre = np.array([0.0, 0.0, at])

    def lead(direction: np.ndarray) -> float:
        """How much further than the capsule the sphere reaches along ``direction``."""
        return float(centre @ direction + radius - max(ends @ direction) - thin)

    assert lead(np.array([0.0, -1.0, 0.0])) > 3e-3
    angles = np.radians(np.arange(-90, 91, 2))
    for roll in angles:  # to either side of the pad
        assert lead(np.array([math.sin(roll), -math.cos(roll), 0.0])) > 0.0
    for pitch in np.radians(np.arange(-12, 91, 2)):  # towards the palm (-) and over the end (+)
        assert lead(np.array([0.0, -math.cos(pitch), math.sin(pitch)])) > 0.0


def test_the_thin_distal_link_stays_joined_to_its_tip(model: pin.Model) -> None:
    links = read_urdf(PATH).links
    for distal, at, radius in (
        ("ffdistal", 0.026, 0.006),
        ("mfdistal", 0.026, 0.006),
        ("thdistal", 0.0275, 0.0075),
    ):
        (capsule,) = links[distal].collisions
        end = capsule.translation[2] + capsule.size[1] / 2 + capsule.size[0]
        assert at - radius < end < at + radius


@pytest.mark.parametrize("name", ["Q0", "Q1", "Q2"])
def test_listed_postures_are_free_of_self_collision(
    model: pin.Model, shapes: pin.GeometryModel, name: str
) -> None:
    assert len(shapes.collisionPairs) > 700
    assert touching(model, shapes, posture(model, name)) == []


def test_self_collision_is_seen(model: pin.Model, shapes: pin.GeometryModel) -> None:
    crossed = configuration(model, FFJ4=0.349, MFJ4=-0.349)
    assert ("ffmiddle_0", "mfmiddle_0") in touching(model, shapes, crossed)


def test_ring_and_little_finger_are_folded_and_fixed(model: pin.Model) -> None:
    joint = model.getJointId("WRJ1")
    q = pin.neutral(model)
    for finger in ("rf", "lf"):
        chain = [f"{finger}{part}" for part in ("knuckle", "proximal", "middle", "distal")]
        places = [placement(model, q, link, "palm") for link in chain]
        assert all(model.frames[model.getFrameId(link)].parentJoint == joint for link in chain)
        tip = places[-1].act(np.array([0.0, 0.0, 0.026]))
        assert tip[1] < -0.012 - 0.006, "in front of the palm, not inside it"
        assert tip[2] < places[0].translation[2], "turned back towards the wrist"
        angles = [pin.log3(a.rotation.T @ b.rotation)[0] for a, b in pairwise(places)]
        assert angles[2] <= angles[1], "the distal joint never flexes more than the middle one"
