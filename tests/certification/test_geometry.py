"""Surface and clearance against brute force on sampled surfaces."""

from __future__ import annotations

from dataclasses import replace

import coal
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.certification.clearance import _lowest
from pivotgait.certification.solid import RigidTool, Solid, rigid_tool
from pivotgait.certification.surface import _probe
from pivotgait.exceptions import PlanFileError
from pivotgait.plans import ContactTrack, GaitPlan

SHAPES = {
    "box": coal.Box(0.02, 0.03, 0.1),
    "sphere": coal.Sphere(0.02),
    "capsule": coal.Capsule(0.01, 0.08),
    "cylinder": coal.Cylinder(0.015, 0.06),
}


def surface_points(kind: str, rng: np.random.Generator, count: int = 40_000) -> np.ndarray:
    """Points on the shape's surface in its own frame, dense near its extremes."""
    ball = rng.normal(size=(count, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    if kind == "box":
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return corners * [0.01, 0.015, 0.05]
    if kind == "sphere":
        return 0.02 * ball
    if kind == "capsule":
        return 0.01 * ball + np.sign(ball[:, 2:]) * [0.0, 0.0, 0.04]
    turn = rng.uniform(0.0, 2.0 * np.pi, count)
    rim = np.stack((np.cos(turn), np.sin(turn), 0 * turn), axis=1) * 0.015
    return rim + np.where(rng.random(count) < 0.5, -0.03, 0.03)[:, None] * [0.0, 0.0, 1.0]


@pytest.mark.parametrize("kind", SHAPES)
def test_support_is_the_lowest_surface_point(kind: str) -> None:
    rng = np.random.default_rng(3)
    points = surface_points(kind, rng)
    for _ in range(10):
        at, tool = Rotation.random(rng=rng).as_matrix(), Rotation.random(rng=rng).as_matrix()
        solid = Solid(SHAPES[kind], at, rng.normal(size=3))
        heights = (points @ at.T + solid.translation) @ tool[2]
        lowest = _lowest(solid, tool[2][None])[0]
        assert lowest <= heights.min() + 1e-15
        assert lowest == pytest.approx(heights.min(), abs=1e-5)


@pytest.mark.parametrize(
    ("kind", "point", "outward"),
    [
        ("box", [0.01, 0.004, 0.03], [1.0, 0.0, 0.0]),
        ("box", [0.003, -0.015, -0.02], [0.0, -1.0, 0.0]),
        ("box", [0.01, 0.015, 0.0], [np.sqrt(0.5), np.sqrt(0.5), 0.0]),  # an edge
        ("sphere", [0.012, 0.0, 0.016], [0.6, 0.0, 0.8]),
        ("capsule", [0.006, 0.008, 0.02], [0.6, 0.8, 0.0]),
        ("capsule", [0.006, 0.0, 0.048], [0.6, 0.0, 0.8]),
        ("cylinder", [0.009, 0.012, 0.01], [0.6, 0.8, 0.0]),
        ("cylinder", [0.004, 0.002, 0.03], [0.0, 0.0, 1.0]),
    ],
)
def test_probe_knows_points_and_normals_of_every_shape(kind, point, outward) -> None:
    rng = np.random.default_rng(5)
    at, shift = Rotation.random(rng=rng), rng.normal(size=3)
    solid = Solid(SHAPES[kind], at.as_matrix(), shift)
    tool = RigidTool(1.0, np.zeros(3), np.eye(3), None, (solid,))
    inward = -at.apply(outward)

    def probe(offset: float) -> tuple[float, float]:
        place = at.apply(point) + shift - offset * inward
        contact = ContactTrack("f", place, inward, np.zeros((2, 3)), 1.0, 0.0, 1.0)
        return _probe(tool, contact, inward)

    base, angle = probe(0.0)
    assert base == pytest.approx(1e-4, abs=1e-9)
    assert angle < 1e-6
    for offset in (-5e-6, 5e-6, 1e-3):
        assert probe(offset)[0] - base == pytest.approx(offset, abs=1e-9)


def test_contact_buried_in_another_shape_is_not_on_the_surface() -> None:
    box, ball = SHAPES["box"], SHAPES["sphere"]
    solids = (Solid(box, np.eye(3), np.zeros(3)), Solid(ball, np.eye(3), np.array([0.01, 0, 0])))
    tool = RigidTool(1.0, np.zeros(3), np.eye(3), None, solids)
    inward = np.array([-1.0, 0.0, 0.0])
    contact = ContactTrack("f", np.array([0.01, 0, 0]), inward, np.zeros((2, 3)), 1.0, 0.0, 1.0)
    assert _probe(tool, contact, inward)[0] < -1e-3


def test_fixed_links_are_one_rigid_body(valid_plan: GaitPlan) -> None:
    """A weight on a fixed joint adds its mass at its place (parallel axes)."""
    weight = """  <link name="weight">
    <inertial>
      <origin xyz="0 0 0" rpy="0 0 0"/>
      <mass value="0.1"/>
      <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>
    </inertial>
  </link>
  <joint name="glue" type="fixed">
    <parent link="rod"/>
    <child link="weight"/>
    <origin xyz="0.13 0 0" rpy="0 0 0"/>
  </joint>
</robot>"""
    planned = valid_plan.tool
    heavier = replace(planned, urdf=planned.urdf.replace("</robot>", weight))
    rigid = rigid_tool(heavier)
    assert rigid.mass == pytest.approx(0.2)
    np.testing.assert_allclose(rigid.centre_of_mass, [0.11, 0.0, 0.0], atol=1e-12)
    assert rigid.inertia[2, 2] == pytest.approx(2.6e-4 + 1e-6 + 0.2 * 0.02**2)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('<capsule radius="0.002" length="0.08"/>', '<mesh filename="x.stl"/>', "."),
        ('version="1.1"', 'version="1.0"', "1.1"),
    ],
)
def test_shapes_that_would_be_lost_are_refused(valid_plan, old, new, says) -> None:
    planned = valid_plan.tool
    with pytest.raises(Exception, match=says) as caught:
        rigid_tool(replace(planned, urdf=planned.urdf.replace(old, new)))
    assert caught.value.exit_code == 2


def test_moving_joint_is_refused(valid_plan: GaitPlan) -> None:
    joint = """  <link name="lid">
    <inertial>
      <mass value="0.1"/>
      <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>
    </inertial>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="rod"/>
    <child link="lid"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"""
    planned = valid_plan.tool
    with pytest.raises(PlanFileError, match="hinge"):
        rigid_tool(replace(planned, urdf=planned.urdf.replace("</robot>", joint)))
