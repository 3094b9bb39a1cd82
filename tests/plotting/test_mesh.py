"""Meshes against the volume and the size of the shape they stand for."""

import numpy as np
import pytest

from pivotgait.plotting import mesh
from pivotgait.plotting.render import Camera, face_normals
from pivotgait.plotting.shapes import tool_surfaces

SOLIDS = {
    "box": (mesh.box((0.1, 0.02, 0.03)), 0.1 * 0.02 * 0.03, 1e-12),
    "cylinder": (mesh.cylinder(0.01, 0.05), np.pi * 0.01**2 * 0.05, 0.03),
    "sphere": (mesh.sphere(0.01), 4 / 3 * np.pi * 0.01**3, 0.06),
    "capsule": (mesh.capsule(0.01, 0.05), np.pi * 0.01**2 * (0.05 + 4 / 3 * 0.01), 0.04),
}


def volume(faces):
    """Divergence theorem over the two triangles of each face."""
    a, b, c, d = np.moveaxis(faces, 1, 0)
    return sum(np.einsum("fi,fi->", p, np.cross(q, r)) for p, q, r in ((a, b, c), (a, c, d))) / 6


@pytest.mark.parametrize("name", SOLIDS)
def test_closed_outward_mesh_has_the_solids_volume(name):
    faces, wanted, tolerance = SOLIDS[name]
    # a positive volume also says that the faces look outward
    assert volume(faces) == pytest.approx(wanted, rel=tolerance or 1e-12)
    assert volume(faces + np.array((1.0, -2.0, 3.0))) == pytest.approx(volume(faces), rel=1e-6)


def test_normals_of_a_sphere_are_radial():
    faces = mesh.sphere(0.02)
    middle = faces.mean(axis=1)
    radial = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    assert np.einsum("fi,fi->f", face_normals(faces), radial).min() > 0.97


def test_arrow_is_as_long_as_told():
    faces = mesh.arrow(0.04, 0.002)
    assert faces[..., 2].min() == 0.0
    assert faces[..., 2].max() == pytest.approx(0.04)


def test_cone_widens_by_its_slope():
    faces = mesh.cone(0.03, 0.8)
    rim = faces[np.isclose(faces[..., 2], 0.03)]
    np.testing.assert_allclose(np.hypot(rim[:, 0], rim[:, 1]), 0.024)


def test_camera_keeps_lengths_across_the_view():
    camera = Camera.looking_from(0.7, 0.5)
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(camera.axes) == pytest.approx(1.0)
    assert camera.axes[0, 2] == 0.0, "the horizon is level"


def test_tool_is_in_its_own_frame_and_its_grip_is_dark(plan):
    surfaces = tool_surfaces(plan.tool)
    points = np.concatenate([surface.faces.reshape(-1, 3) for surface in surfaces])
    reach = points.max(axis=0) - plan.tool.pivot_in_tool
    assert reach[0] == pytest.approx(0.001, abs=2e-4), "the tip sphere ends the tool"
    assert np.ptp(points, axis=0)[0] == pytest.approx(0.337, abs=2e-3)
    assert len({surface.colour for surface in surfaces}) == 3


def test_faces_inside_the_tool_are_left_out(plan):
    shown = sum(len(surface.faces) for surface in tool_surfaces(plan.tool))
    handle = [s for s in tool_surfaces(plan.tool) if s.colour == "#45413E"]
    whole = len(mesh.box((0.118, 0.02, 0.009))) + 2 * len(mesh.capsule(0.01, 0.098))
    assert 0 < sum(len(s.faces) for s in handle) < whole
    assert shown > 0
