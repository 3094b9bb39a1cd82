"""Pinocchio, Bullet and the checked record read one tool URDF alike."""

from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pybullet
import pytest

from pivotgait.models import load_scene, urdf_root
from pivotgait.models.urdf import UrdfSummary, read_urdf

TOOLS = {
    "chef_knife": (0.225, (-0.220, 0.0, -0.014), (1.85e-5, 1.212e-3, 1.198e-3)),
    "screwdriver": (0.097, (-0.1305, 0.0, 0.0), (7.0e-6, 3.12e-4, 3.12e-4)),
    "wrench": (0.252, (-0.0709, 0.0, 0.0045), (3.80e-5, 7.96e-4, 8.29e-4)),
}


@pytest.fixture(params=TOOLS)
def summary(request: pytest.FixtureRequest) -> UrdfSummary:
    return read_urdf(urdf_root() / request.param / f"{request.param}.urdf")


@pytest.fixture
def client() -> Iterator[int]:
    identity = pybullet.connect(pybullet.DIRECT)
    yield identity
    pybullet.disconnect(identity)


def test_numbers_are_those_of_the_readme(summary: UrdfSummary) -> None:
    mass, centre, moments = TOOLS[summary.name]
    inertial = summary.links[summary.root].inertial
    assert inertial is not None
    assert inertial.mass == mass
    np.testing.assert_array_equal(inertial.centre_of_mass, centre)
    np.testing.assert_array_equal(np.diag(inertial.inertia), moments)


def test_pinocchio_reads_the_same_body_and_drops_no_shape(summary: UrdfSummary) -> None:
    path = str(urdf_root() / summary.name / f"{summary.name}.urdf")
    free = pin.JointModelFreeFlyer()
    model, collision, visual = pin.buildModelsFromUrdf(path, root_joint=free)
    body, inertial = model.inertias[1], summary.links[summary.root].inertial
    assert inertial is not None
    assert body.mass == inertial.mass
    np.testing.assert_allclose(body.lever, inertial.centre_of_mass, rtol=0, atol=1e-15)
    np.testing.assert_allclose(body.inertia, inertial.inertia, rtol=0, atol=1e-18)

    written = len(ElementTree.fromstring(summary.text).findall(".//collision"))
    assert collision.ngeoms == visual.ngeoms == written == len(summary.collisions)
    for seen, shape in zip(collision.geometryObjects, summary.collisions, strict=True):
        assert type(seen.geometry).__name__.lower() == shape.kind
        np.testing.assert_allclose(seen.placement.rotation, shape.rotation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(
            seen.placement.translation, shape.translation, rtol=0, atol=1e-15
        )


def test_bullet_reads_the_same_body_and_drops_no_shape(summary: UrdfSummary, client: int) -> None:
    path = str(urdf_root() / summary.name / f"{summary.name}.urdf")
    flags = pybullet.URDF_USE_INERTIA_FROM_FILE
    body = pybullet.loadURDF(path, flags=flags, physicsClientId=client)
    info = pybullet.getDynamicsInfo(body, -1, physicsClientId=client)
    mass, principal, centre, axes = info[0], info[2], info[3], info[4]
    turn = np.reshape(pybullet.getMatrixFromQuaternion(axes), (3, 3))
    inertial = summary.links[summary.root].inertial
    assert inertial is not None
    assert mass == pytest.approx(inertial.mass, rel=1e-12)
    np.testing.assert_allclose(centre, inertial.centre_of_mass, rtol=0, atol=1e-12)
    # Bullet keeps principal moments and the turn of their axes.
    inertia = turn @ np.diag(principal) @ turn.T
    np.testing.assert_allclose(inertia, inertial.inertia, rtol=0, atol=1e-10)
    shapes = pybullet.getCollisionShapeData(body, -1, physicsClientId=client)
    assert len(shapes) == len(summary.collisions)


@pytest.mark.parametrize("scene", ["knife", "screwdriver", "wrench"])
def test_a_tool_is_the_body_pinocchio_reads(scene: str) -> None:
    tool = load_scene(scene).tool
    body = pin.buildModelFromXML(tool.urdf, pin.JointModelFreeFlyer()).inertias[1]
    assert tool.mass == body.mass
    np.testing.assert_allclose(tool.inertia, body.inertia, rtol=0, atol=1e-18)
    np.testing.assert_allclose(tool.centre_of_mass_in_root, body.lever, rtol=0, atol=1e-15)
    # The built-in tools have their tip at the root's origin.
    np.testing.assert_allclose(tool.pivot_in_tool, -body.lever, rtol=0, atol=1e-15)
