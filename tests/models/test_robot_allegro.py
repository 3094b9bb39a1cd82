"""The Allegro hand: the source's kinematics and masses, shapes around its meshes, real inertias."""

import re

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.models import Shape, urdf_root
from pivotgait.models.enclosing import read_vertices
from pivotgait.models.urdf import read_urdf
from pivotgait.models.urdf.nodes import Node, read_nodes
from pivotgait.models.urdf_files import example_robots

FOLDER = urdf_root() / "allegro_right_hand"
SUMMARY = read_urdf(FOLDER / "allegro_right_hand.urdf")
ROBOTS = example_robots()
assert ROBOTS is not None, "a dependency of the package"
SOURCE_PATH = ROBOTS / "allegro_hand_description/urdf/allegro_right_hand.urdf"
SOURCE = read_nodes(SOURCE_PATH.read_text(), where="source")
TIPS = tuple(f"link_{n}.0_tip" for n in (3, 7, 11, 15))


def first(node: Node, *tags: str) -> Node:
    for tag in tags:
        node = next(node.all(tag))
    return node


def test_kinematics_and_limits_are_those_of_the_source() -> None:
    source, ours = (
        pin.buildModelFromUrdf(str(p)) for p in (SOURCE_PATH, FOLDER / "allegro_right_hand.urdf")
    )
    assert list(source.names) == list(ours.names)
    assert ours.nv == 16
    np.testing.assert_array_equal(source.lowerPositionLimit, ours.lowerPositionLimit)
    np.testing.assert_array_equal(source.upperPositionLimit, ours.upperPositionLimit)
    np.testing.assert_array_equal(source.upperVelocityLimit, ours.upperVelocityLimit)
    q = np.random.default_rng(0).uniform(ours.lowerPositionLimit, ours.upperPositionLimit)
    data = [model.createData() for model in (source, ours)]
    for model, each in zip((source, ours), data, strict=True):
        pin.framesForwardKinematics(model, each, q)
    for link in SUMMARY.links:
        a, b = (
            each.oMf[model.getFrameId(link, pin.FrameType.BODY)].homogeneous
            for model, each in zip((source, ours), data, strict=True)
        )
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12, err_msg=link)


def test_masses_are_those_of_the_source_and_the_readme() -> None:
    for link in SOURCE.all("link"):
        inertial = SUMMARY.links[link.attributes["name"]].inertial
        assert inertial is not None
        assert inertial.mass == float(first(link, "inertial", "mass").attributes["value"])
    said = re.findall(r"^\| whole hand \| ([0-9.]+) kg", (FOLDER / "README.md").read_text(), re.M)
    assert SUMMARY.mass == pytest.approx(float(said[0]), abs=1e-12)


def test_an_inertia_is_that_of_the_evenly_filled_shape() -> None:
    for link in SUMMARY.links.values():
        (shape,), inertial = link.collisions, link.inertial
        assert inertial is not None
        np.testing.assert_allclose(inertial.centre_of_mass, shape.translation, rtol=0, atol=1e-12)
        if shape.kind == "sphere":
            expected = pin.Inertia.FromSphere(inertial.mass, *shape.size).inertia
        else:
            expected = pin.Inertia.FromBox(inertial.mass, *shape.size).inertia
        np.testing.assert_allclose(inertial.inertia, expected, rtol=1e-8, atol=1e-20)


def test_shapes_enclose_the_meshes_of_the_source() -> None:
    for link in SOURCE.all("link"):
        name = link.attributes["name"]
        (shape,) = SUMMARY.links[name].collisions
        file = first(link, "visual", "geometry", "mesh").attributes["filename"]
        path = ROBOTS / file.removeprefix("package://example-robot-data/robots/")
        drawn = Shape("m", "mesh", (1.0, 1.0, 1.0), np.eye(3), np.zeros(3), path)
        vertices = read_vertices(drawn, where=name)
        if shape.kind == "sphere":  # the neck behind it is left out, as the README says
            dome = vertices[vertices[:, 2] >= 0.0]
            assert np.linalg.norm(dome, axis=1).max() <= shape.size[0] + 1e-6, name
        else:
            beyond = np.abs(shape.to_local(vertices)) - 0.5 * np.array(shape.size)
            assert beyond.max() <= 1e-5, name
            assert beyond.max(axis=0).min() > -2e-4, f"{name} has no slack"


@pytest.mark.parametrize("tip", TIPS)
def test_the_tip_sphere_is_outermost_on_the_pad_side(tip: str) -> None:
    joint = next(joint for joint in SUMMARY.joints.values() if joint.child == tip)
    (sphere,), (box,) = SUMMARY.links[tip].collisions, SUMMARY.links[joint.parent].collisions
    assert (sphere.kind, sphere.size) == ("sphere", (0.012,))
    np.testing.assert_array_equal(sphere.translation, np.zeros(3))
    half = 0.5 * np.array(box.size)

    def lead(direction: np.ndarray) -> float:
        reach = float(joint.translation @ direction) + sphere.size[0]
        return reach - float(box.translation @ direction + half @ np.abs(direction))

    assert lead(np.array([1.0, 0.0, 0.0])) == pytest.approx(0.0022, abs=1e-9)
    # from towards the palm (-) to over the end (+)
    for pitch in np.radians(np.arange(-2.4, 90.1, 0.4)):
        assert lead(np.array([np.cos(pitch), 0.0, np.sin(pitch)])) > 0.0
    assert joint.translation[2] - box.translation[2] - half[2] > 0.0109, "the box ends behind"
