"""Tools: the frame, the rest on the table, and places on the handle."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pivotgait.exceptions import SceneError, UnknownNameError, UrdfError
from pivotgait.models import (
    Handle,
    Shape,
    Tool,
    attitude,
    load_scene,
    load_tool,
    rest_pitch,
    urdf_root,
)
from pivotgait.models.coal_shapes import ball_distance

SCENES = ("knife", "screwdriver", "wrench")
TOOLS = {name: load_scene(name).tool for name in SCENES}
angles = st.floats(-3.1, 3.1)
OTHER_LINK = """<link name="b"/>
<joint name="j" type="fixed">
<parent link="wrench"/>
<child link="b"/>
</joint>
</robot>"""


def urdf(name: str) -> str:
    return str(urdf_root() / name / f"{name}.urdf")


def load(name: str = "wrench", **changes: object) -> Tool:
    given = {
        "tip": "tip",
        "handle": ("handle",),
        "origin": np.array([-0.06, 0.0, 0.0045]),
        "axis": np.array([-2.0, 0.0, 0.0]),
        "zero": np.array([0.0, 0.0, 3.0]),
    }
    return load_tool(urdf(name), **{**given, **changes})  # type: ignore[arg-type]


def lowest(tool: Tool, rotation: np.ndarray) -> float:
    """Height over the table by Coal, shape by shape: the law behind ``Tool.height``."""
    # A huge ball from below stands for the table: its top touches the tip's lowest point.
    up, size = rotation[2], 1e4
    centre = tool.pivot_in_tool - (tool.tip_radius + size) * up
    others = [shape for shape in tool.shapes if shape.name != tool.tip.name]
    return min(ball_distance(shape, centre, size)[0] for shape in others)


@pytest.mark.parametrize("name", SCENES)
def test_arrays_are_read_only(name: str) -> None:
    tool = TOOLS[name]
    for array in (tool.inertia, tool.pivot_in_tool, tool.handle.axis, *tool.support_points()):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


@pytest.mark.parametrize("name", SCENES)
def test_the_tip_is_out_in_front(name: str) -> None:
    tool = TOOLS[name]
    points, _ = tool.support_points()
    assert np.max(points[:, 0]) < tool.pivot_in_tool[0] - 0.005


@pytest.mark.parametrize("name", SCENES)
@given(yaw=angles, pitch=angles, roll=angles)
@settings(max_examples=30, deadline=None)
def test_height_is_what_coal_measures_and_yaw_does_not_matter(
    name: str, yaw: float, pitch: float, roll: float
) -> None:
    tool = TOOLS[name]
    rotation = attitude(yaw, pitch, roll).as_matrix()
    height = float(tool.height(rotation))
    assert height == pytest.approx(lowest(tool, rotation), abs=2e-5)  # the ball's curvature
    assert height == pytest.approx(float(tool.height(attitude(0.0, pitch, roll).as_matrix())))


def test_height_takes_many_rotations() -> None:
    tool, turns = TOOLS["knife"], attitude(0.0, 0.3, 0.0)
    stack = np.stack([np.eye(3), turns.as_matrix()])
    np.testing.assert_allclose(tool.height(stack), [tool.height(r) for r in stack])


@pytest.mark.parametrize("name", SCENES)
@given(roll=st.floats(-np.pi, np.pi))
@settings(max_examples=50, deadline=None)
def test_rest_touches_and_a_little_less_pitch_would_not(name: str, roll: float) -> None:
    tool = TOOLS[name]
    try:
        pitch = rest_pitch(tool, roll)
    except SceneError:
        return
    assert abs(float(tool.height(attitude(0.0, pitch, roll).as_matrix()))) < 1e-9
    assert float(tool.height(attitude(0.0, pitch - 1e-4, roll).as_matrix())) < 0.0
    assert float(tool.height(attitude(0.0, pitch + 1e-3, roll).as_matrix())) > -1e-9


def test_known_rests() -> None:
    # Knife on its side: the handle's front edge, 9 mm thicker than the tip, 226 mm behind it.
    reach = np.hypot(0.226, 0.010)
    by_hand = np.arcsin((0.010 * 0.226 - 0.001 * 0.226) / (0.226 * reach))
    knife = rest_pitch(TOOLS["knife"], np.pi / 2)
    assert 0.226 * np.sin(knife) == pytest.approx(0.010 * np.cos(knife) - 0.001, abs=1e-12)
    assert knife == pytest.approx(by_hand, abs=2e-3)
    assert rest_pitch(TOOLS["wrench"], 0.0) == pytest.approx(0.0, abs=1e-12)
    # Screwdriver: the wide part of the handle is full from 148 mm behind the tip on.
    expected = np.arcsin((0.0155 - 0.0015) / 0.148)
    assert rest_pitch(TOOLS["screwdriver"], 0.0) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", SCENES)
@given(along=st.floats(0.012, 0.095), around=st.floats(0.0, 2.0 * np.pi))
@settings(max_examples=60, deadline=None)
def test_places_lie_on_the_surface_and_their_normals_are_coals(
    name: str, along: float, around: float
) -> None:
    tool = TOOLS[name]
    try:
        place = tool.place(along, around)
    except SceneError as error:
        refusal = str(error)
    else:
        refusal = ""
    if refusal:
        assert "edge" in refusal or (name == "screwdriver" and "hidden by shape" in refusal)
        return
    assert np.linalg.norm(place.normal) == pytest.approx(1.0)
    probe = place.point - 3e-3 * place.normal
    measured = min(
        (ball_distance(shape, probe, 1e-3) for shape in tool.shapes), key=lambda entry: entry[0]
    )
    assert measured[0] == pytest.approx(2e-3, abs=1e-6)
    np.testing.assert_allclose(measured[1], place.point, rtol=0, atol=3e-6)
    out = place.point - tool.handle.origin - along * tool.handle.axis
    assert out @ place.normal < 0.0, "the normal points into the handle"
    assert abs(out @ tool.handle.axis) < 1e-12


def test_angles_turn_right_handed_about_the_axis() -> None:
    for name, half in (("knife", 0.010), ("screwdriver", 0.0155), ("wrench", 0.0115)):
        tool = TOOLS[name]
        point = tool.place(0.05, np.pi / 2).point + tool.centre_of_mass_in_root
        np.testing.assert_allclose(point[1], half, rtol=0, atol=1e-12)


def test_opposite_places_of_the_knife_face_each_other() -> None:
    spine, edge = (TOOLS["knife"].place(0.045, angle) for angle in (0.0, np.pi))
    np.testing.assert_allclose(spine.normal, -edge.normal, rtol=0, atol=1e-12)
    between = edge.point - spine.point
    assert np.linalg.norm(between) == pytest.approx(0.029)
    np.testing.assert_allclose(between / 0.029, spine.normal, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "along", "around", "fragment"),
    [
        ("wrench", -0.01, 0.0, "off the handle - choose it within"),
        ("wrench", 0.2, 0.0, "off the handle"),
        ("screwdriver", 0.5, 0.0, "off the handle"),
        ("wrench", 0.05, np.arctan2(0.0115, 0.00325), "on an edge"),
        ("knife", -1e-4, 0.0, "off the handle"),
        ("wrench", np.nan, 0.0, "not finite"),
        ("wrench", 0.05, np.inf, "not finite"),
    ],
)
def test_bad_places(name: str, along: float, around: float, fragment: str) -> None:
    with pytest.raises(SceneError, match=fragment) as caught:
        TOOLS[name].place(along, around, where="here")
    assert caught.value.where == "here"


def test_a_place_inside_another_shape_is_refused() -> None:
    tool = load(origin=np.array([-0.06, 0.0, 0.0045]), handle=("jaw", "handle"))
    with pytest.raises(SceneError, match="hidden by shape 'head'"):
        # The jaw's back face lies against the head.
        load(
            handle=("jaw",),
            origin=np.array([-0.0155, 0.0, 0.0045]),
            axis=np.array([0.0, 0.0, 1.0]),
            zero=np.array([-1.0, 0.0, 0.0]),
        ).place(0.0, 0.0)
    assert tool.place(0.05, 0.0).normal[2] == -1.0


def box(name: str, height: float, at: float) -> Shape:
    return Shape(name, "box", (0.1, 0.1, height), np.eye(3), np.array([0.0, 0.0, at]))


def test_a_place_is_on_the_far_side_of_touching_shapes_and_on_the_near_side_of_a_gap() -> None:
    axes = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    core, touching, beyond = box("a", 0.02, 0.0), box("b", 0.02, 0.02), box("c", 0.02, 0.045)
    for order in ((core, touching, beyond), (beyond, touching, core)):
        place = Handle(order, *axes).place(0.0, 0.0)
        np.testing.assert_allclose(place.point, [0.0, 0.0, 0.03], rtol=0, atol=1e-12)
    np.testing.assert_allclose(Handle((core, beyond), *axes).place(0.0, 0.0).point[2], 0.01)


def test_a_place_where_two_surfaces_cross_is_an_edge() -> None:
    ball = Shape("b", "sphere", (0.05,), np.eye(3), np.array([0.03, 0.0, -0.03]))
    handle = Handle((box("a", 0.02, 0.0), ball), np.zeros(3), np.eye(3)[0], np.eye(3)[2])
    with pytest.raises(SceneError, match="on an edge"):
        handle.place(0.0, 0.0)  # the ball's surface passes through (0, 0, 0.01)


def test_a_handle_axis_that_misses_its_shapes_is_refused() -> None:
    with pytest.raises(SceneError, match="misses its shapes"):
        load(origin=np.array([-0.06, 0.0, 0.5])).place(0.05, 0.0)


def test_bad_tools() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'handle'"):
        load(handle=("handel",))
    with pytest.raises(UnknownNameError, match="unknown collision shape 'point'"):
        load(tip="point")
    with pytest.raises(UrdfError, match="the tip 'jaw' is a box"):
        load(tip="jaw")


@pytest.mark.parametrize(
    ("old", "new", "fragment"),
    [
        ('<sphere radius="0.002"/>', '<sphere radius="0.0001"/>', None),
        ('xyz="-0.0155 0 0.0045"', 'xyz="0.005 0 -0.0045"', "cannot rest on its tip"),
        ('<box size="0.115 0.023 0.0065"/>', '<sphere radius="0.3"/>', "surrounds the tip"),
    ],
)
def test_tools_that_cannot_rest(old: str, new: str, fragment: str | None, tmp_path: Path) -> None:
    text = Path(urdf("wrench")).read_text()
    assert old in text
    path = tmp_path / "t.urdf"
    path.write_text(text.replace(old, new))
    tool = load_tool(
        path,
        tip="tip",
        handle=("head",),
        origin=np.zeros(3),
        axis=np.array([1.0, 0.0, 0.0]),
        zero=np.array([0.0, 0.0, 1.0]),
    )
    if fragment is None:  # a tip that is small but in front still touches first
        assert rest_pitch(tool, 0.0) > 0.0
        return
    with pytest.raises(SceneError, match=fragment):
        rest_pitch(tool, 0.0, where="rest")


@pytest.mark.parametrize(
    ("old", "new", "fragment"),
    [
        ("<sphere radius", "<cylinder length='1' radius", "the tip 'tip' is a cylinder"),
        ('<box size="0.019 0.02 0.013"/>', '<mesh filename="a.stl"/>', "'jaw' is a mesh"),
        ("</robot>", OTHER_LINK, "a tool is one rigid link, found 2"),
    ],
)
def test_urdfs_that_are_no_tools(old: str, new: str, fragment: str, tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text("solid a")
    text, path = Path(urdf("wrench")).read_text(), tmp_path / "t.urdf"
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(UrdfError, match=fragment):
        load_tool(
            path,
            tip="tip",
            handle=("handle",),
            origin=np.zeros(3),
            axis=np.eye(3)[0],
            zero=np.eye(3)[2],
        )


def test_a_tool_needs_mass_properties(tmp_path: Path) -> None:
    text = Path(urdf("wrench")).read_text()
    start, end = text.index("    <inertial>"), text.index("</inertial>") + len("</inertial>")
    (tmp_path / "t.urdf").write_text(text[:start] + text[end:])
    with pytest.raises(UrdfError, match="the tool has no mass"):
        load_tool(
            tmp_path / "t.urdf",
            tip="tip",
            handle=("handle",),
            origin=np.zeros(3),
            axis=np.eye(3)[0],
            zero=np.eye(3)[2],
        )
