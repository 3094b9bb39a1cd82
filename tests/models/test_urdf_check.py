"""URDFs that must not reach a native parser, and some that must."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import UrdfError
from pivotgait.models.urdf import check_urdf

GOOD = """<?xml version="1.0"?>
<robot name="r" version="1.1">
  <material name="grey">
    <color rgba="0.5 0.5 0.5 1"/>
  </material>
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0.1 0 0" rpy="0 0 0.5"/>
      <mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.025"/>
    </inertial>
    <collision name="bar">
      <origin xyz="0 0 0.1" rpy="0 0.3 0"/>
      <geometry>
        <capsule radius="0.02" length="0.2"/>
      </geometry>
    </collision>
    <collision name="block">
      <geometry>
        <box size="0.1 0.2 0.3"/>
      </geometry>
    </collision>
    <visual>
      <geometry>
        <sphere radius="0.3"/>
      </geometry>
      <material name="grey"/>
    </visual>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/>
    <child link="arm"/>
    <origin xyz="0 0 0.5"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
    <dynamics damping="0.001"/>
    <safety_controller k_velocity="1"/>
    <calibration rising="0"/>
  </joint>
</robot>
"""
MESH = '<mesh filename="{}"/>'
CAPSULE = '<capsule radius="0.02" length="0.2"/>'
ARM = '<link name="arm">'
JOINT = '<joint name="turn" type="revolute">'
BOMB = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>\n<robot name="r" version="1.1">'

BAD = {
    "nan mass": ('<mass value="2"/>', '<mass value="nan"/>', "value is not finite: 'nan'"),
    "infinite mass": ('<mass value="2"/>', '<mass value="1e999"/>', "overflows"),
    "negative mass": ('<mass value="2"/>', '<mass value="-2"/>', "greater than 0, got -2"),
    "zero mass": ('<mass value="2"/>', '<mass value="0"/>', "greater than 0, got 0"),
    "no mass": ('<mass value="2"/>', "", "has no <mass>"),
    "mass without value": ('<mass value="2"/>', "<mass/>", "<mass> has no 'value'"),
    "decimal comma": ('<mass value="2"/>', '<mass value="1,5"/>', "write a decimal point: 1.5"),
    "hexadecimal": ('<mass value="2"/>', '<mass value="0x10"/>', "not a number: '0x10'"),
    "unit in number": ('<mass value="2"/>', '<mass value="2kg"/>', "not a number: '2kg'"),
    "underscore in number": ('<mass value="2"/>', '<mass value="2_0"/>', "not a number"),
    "negative inertia": ('ixx="0.01"', 'ixx="-0.01"', "not positive definite"),
    "zero inertia": ('ixx="0.01"', 'ixx="0"', "not positive definite"),
    "large product of inertia": ('ixy="0"', 'ixy="0.05"', "not positive definite"),
    "triangle inequality": ('izz="0.025"', 'izz="0.04"', "breaks the triangle inequality"),
    "no inertia moment": ('ixx="0.01"', "", "<inertia> has no 'ixx'"),
    "no inertia product": (' ixz="0"', "", "<inertia> has no 'ixz'"),
    "two inertials": (ARM, ARM + "<inertial/>", "has 2 <inertial> elements"),
    "tab between numbers": ('xyz="0 0 0.5"', 'xyz="0\t0 0.5"', "holds a tab or a line break"),
    "line break in a value": ('size="0.1 ', 'size="0.1\n', "holds a tab or a line break"),
    "blank after a name": ('name="turn"', 'name="turn "', "name 'turn ' has blanks around it"),
    "blank before a number": ('value="2"', 'value=" 2"', "value is not a number: ' 2'"),
    "empty dynamics": (' damping="0.001"', "", "neither damping nor friction"),
    "material without name": ('<material name="grey"/>', "<material/>", "has no 'name'"),
    "material twice": (
        ARM,
        '<link name="x"/><material name="grey"/>' + ARM,
        "two materials are called 'grey'",
    ),
    "colour of three": ("0.5 0.5 0.5 1", "0.5 0.5 0.5", "rgba needs 4 numbers"),
    "colour of bytes": ("0.5 0.5 0.5 1", "128 128 128 1", "leaves 0 to 1"),
    "safety without speed": ("k_velocity", "k_speed", "has no 'k_velocity'"),
    "calibration": ('rising="0"', 'rising="x"', "rising is not a number: 'x'"),
    "two numbers": ('xyz="0 0 0.5"', 'xyz="0 0.5"', "xyz needs 3 numbers"),
    "four numbers": ('xyz="0 0 0.5"', 'xyz="0 0 0 0.5"', "xyz needs 3 numbers"),
    "nan in origin": ('xyz="0 0 0.5"', 'xyz="0 NaN 0.5"', "xyz is not finite"),
    "commas between numbers": ('xyz="0 0 0.5"', 'xyz="0,0,0.5"', "xyz is not a number"),
    "zero box side": ('size="0.1 0.2 0.3"', 'size="0.1 0 0.3"', "size must be greater than 0"),
    "negative radius": ('radius="0.02"', 'radius="-0.02"', "radius must be greater than 0"),
    "unknown geometry": ("<box size", "<cone size", "unknown geometry <cone>"),
    "two geometries": (CAPSULE, CAPSULE * 2, "<geometry> holds 2 elements"),
    "capsule in version 1.0": ('version="1.1"', 'version="1.0"', "needs version 1.1"),
    "capsule without version": (' version="1.1"', "", "needs version 1.1"),
    "odd version": (
        'version="1.1"',
        'version="one"',
        "unknown URDF version 'one' - use one of 1.0, 1.1",
    ),
    "newer version": ('version="1.1"', 'version="1.3"', "unknown URDF version '1.3'"),
    "limits out of order": ('lower="-1"', 'lower="2"', "limits are out of order: [2, 1]"),
    "no limit": (
        '<limit lower="-1" upper="1" effort="10" velocity="2"/>',
        "",
        "has no <limit>",
    ),
    "no effort": ('effort="10" ', "", "<limit> has no 'effort'"),
    "zero effort": ('effort="10"', 'effort="0"', "effort must be greater than 0"),
    "zero axis": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "not of unit length"),
    "negative damping": ('damping="0.001"', 'damping="-1"', "damping must not be negative"),
    "continuous": ('type="revolute"', 'type="continuous"', "make it revolute with limits"),
    "ball joint": ('type="revolute"', 'type="ball"', "unknown joint type 'ball'"),
    "mimic": (JOINT, JOINT + '<mimic joint="x"/>', "mimic joints are not supported"),
    "unknown parent": ('parent link="base"', 'parent link="bass"', "unknown parent link 'bass'"),
    "unknown child": ('child link="arm"', 'child link="leg"', "unknown child link 'leg'"),
    "own parent": ('parent link="base"', 'parent link="arm"', "link 'arm' is in a loop"),
    "two roots": (ARM, '<link name="stray"/>' + ARM, "has 2 root links: 'base', 'stray'"),
    "two links of one name": (ARM, '<link name="base"/>' + ARM, "two links are called 'base'"),
    "two shapes of one name": ('name="block"', 'name="bar"', "two collisions are called 'bar'"),
    "link without name": ('<link name="base"/>', "<link/>", "<link> has no 'name'"),
    "misspelt collision": (
        ARM,
        ARM + "<colision/>",
        "unknown element <colision> - did you mean <collision>?",
    ),
    "xacro": (ARM, "<xacro:macro/>" + ARM, "expand the file with xacro first"),
    "entity bomb": ('<robot name="r" version="1.1">', BOMB, "has a <!DOCTYPE> declaration"),
    "long line": ('name="r"', f'name="r" note="{"x" * 1000}"', "line 2: has 1"),
    "deep nesting": (ARM, "<a>" * 40 + "</a>" * 40 + ARM, "more than 32 levels"),
    "not closed": ("</robot>", "", "not well-formed XML: no element found"),
    "crossed": ("</geometry>", "</robot>", "not well-formed XML: mismatched tag"),
    "attribute twice": ('name="r"', 'name="r" name="s"', "duplicate attribute"),
    "undefined entity": ('name="r"', 'name="&r;"', "undefined entity"),
    "two robots": ("</robot>", "</robot><robot/>", "junk after document element"),
    "wrong root": ("robot", "model", "the root element is <model>"),
    "mesh above its package": (
        CAPSULE,
        MESH.format("package://../../etc/passwd"),
        "outside the allowed folders",
    ),
    "mesh at an absolute path": (CAPSULE, MESH.format("/etc/passwd"), "outside the allowed"),
    "mesh by file address": (CAPSULE, MESH.format("file:///etc/passwd"), "outside the allowed"),
    "mesh of no size": (CAPSULE, '<mesh filename="a" scale="1 0 1"/>', "a scale factor is 0"),
    "mesh that is missing": (CAPSULE, MESH.format("none.stl"), "'none.stl' does not exist"),
    "mesh with an endless name": (CAPSULE, MESH.format("n" * 300), "does not exist"),
    "mesh by web address": (CAPSULE, MESH.format("http://x.org/a.stl"), "does not exist"),
}


def edited(old: str, new: str) -> str:
    assert old in GOOD
    return GOOD.replace(old, new)


@pytest.mark.parametrize(("old", "new", "fragment"), BAD.values(), ids=BAD)
def test_bad_urdf(old: str, new: str, fragment: str, tmp_path: Path) -> None:
    with pytest.raises(UrdfError) as caught:
        check_urdf(edited(old, new), where="r.urdf", roots=[tmp_path])
    message = str(caught.value)
    assert fragment in message
    assert message.startswith("r.urdf: ") or message.startswith("r.urdf (line ")
    assert caught.value.mend
    assert "\n" not in message
    assert caught.value.exit_code == 2


def test_good_urdf_is_read_in_full() -> None:
    summary = check_urdf(GOOD, where="r.urdf")
    assert (summary.name, summary.version, summary.root) == ("r", "1.1", "base")
    assert summary.mass == 2.0
    bar, block = summary.collisions
    assert (bar.kind, bar.size, block.size) == ("capsule", (0.02, 0.2), (0.1, 0.2, 0.3))
    np.testing.assert_allclose(bar.rotation, Rotation.from_euler("y", 0.3).as_matrix())
    joint = summary.joints["turn"]
    assert (joint.kind, joint.parent, joint.child) == ("revolute", "base", "arm")
    assert (joint.lower, joint.upper, joint.effort, joint.velocity) == (-1.0, 1.0, 10.0, 2.0)
    inertial = summary.links["arm"].inertial
    assert inertial is not None
    moments = np.linalg.eigvalsh(inertial.inertia)
    np.testing.assert_allclose(moments, [0.01, 0.02, 0.025])
    assert inertial.inertia[0, 1] != 0.0, "the inertial frame's turn is applied"


def test_message_names_file_element_and_line() -> None:
    with pytest.raises(UrdfError) as caught:
        check_urdf(edited('value="2"', 'value="nan"'), where="r.urdf")
    assert str(caught.value) == (
        "r.urdf: link 'arm', inertial, mass (line 10): value is not finite: 'nan' "
        "- give a finite number"
    )


def test_moving_link_without_mass() -> None:
    text = GOOD[: GOOD.index("    <inertial>")] + GOOD[GOOD.index("    <collision") :]
    with pytest.raises(UrdfError, match="moves link 'arm' without mass"):
        check_urdf(text, where="r.urdf")


def test_a_fixed_frame_may_weigh_nothing_but_a_moving_link_may_not() -> None:
    zero = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    text = GOOD.replace('value="2"', 'value="0"')
    start, end = text.index("<inertia ixx"), text.index("</inertial>")
    text = text[:start] + zero + text[end:]
    with pytest.raises(UrdfError, match="moves link 'arm' without mass"):
        check_urdf(text, where="r.urdf")
    fixed = check_urdf(text.replace('"revolute"', '"fixed"'), where="r.urdf")
    assert fixed.links["arm"].inertial is None
    assert fixed.mass == 0.0


def test_loop_beside_the_tree() -> None:
    joint = '<joint name="{0}{1}" type="fixed"><parent link="{0}"/><child link="{1}"/></joint>\n'
    links = "".join(f'<link name="{name}"/>\n' for name in "abc")
    robot = f'<robot name="r">\n{links}{joint.format("b", "c")}{joint.format("c", "b")}</robot>'
    with pytest.raises(UrdfError, match="is in a loop"):
        check_urdf(robot, where="r.urdf")
    both = links + joint.format("a", "c") + joint.format("b", "c")
    with pytest.raises(UrdfError, match="link 'c' has two parents"):
        check_urdf(f'<robot name="r">\n{both}</robot>', where="r.urdf")


def test_too_many_links_and_too_many_bytes() -> None:
    many = "".join(f'<link name="l{i}"/>\n' for i in range(201))
    with pytest.raises(UrdfError, match="has 201 links"):
        check_urdf(f'<robot name="r">\n{many}</robot>', where="r.urdf")
    with pytest.raises(UrdfError, match="the limit is 2000000"):
        check_urdf("<robot>" + "\n" * 2_000_001, where="r.urdf")


@given(st.integers(0, len(GOOD) - 1), st.sampled_from(list("0123456789.-+eE, <>/\"'&;ax\n\t")))
@settings(max_examples=300, deadline=None)
def test_what_passes_pinocchio_reads_alike(place: int, character: str) -> None:
    text = GOOD[:place] + character + GOOD[place + 1 :]
    try:
        summary = check_urdf(text, where="r.urdf")
    except UrdfError:
        return
    model = pin.buildModelFromXML(text)
    collision = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    assert collision.ngeoms == len(summary.collisions)
    for link in summary.links.values():
        frame = model.frames[model.getFrameId(link.name, pin.FrameType.BODY)]
        if link.inertial is not None:
            body = model.inertias[frame.parentJoint]
            assert body.mass == link.inertial.mass
            np.testing.assert_allclose(body.lever, link.inertial.centre_of_mass, atol=1e-12)
            np.testing.assert_allclose(body.inertia, link.inertial.inertia, rtol=1e-9)
    for name, joint in summary.joints.items():
        if joint.kind != "fixed":
            index = model.joints[model.getJointId(name)].idx_q
            assert model.lowerPositionLimit[index] == joint.lower
            assert model.upperPositionLimit[index] == joint.upper
            placement = model.jointPlacements[model.getJointId(name)]
            np.testing.assert_allclose(placement.translation, joint.translation, atol=1e-12)
