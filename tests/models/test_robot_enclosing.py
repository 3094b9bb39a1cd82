"""Primitives around meshes: nothing of the mesh is outside, and not much of the primitive."""

from pathlib import Path

import coal
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import UrdfError
from pivotgait.models import Shape
from pivotgait.models.enclosing import enclosing_primitive, read_vertices, volume
from pivotgait.models.urdf_files import example_robots

ROBOTS = example_robots()
assert ROBOTS is not None, "a dependency of the package"
MESHES = [
    *sorted((ROBOTS / "ur_description/meshes/ur5/collision").glob("*.stl")),
    *sorted((ROBOTS / "allegro_hand_description/meshes").glob("link_1*.STL")),
]


def excess(shape: Shape, points: np.ndarray) -> float:
    """Largest distance of points (N, 3) of the holder's frame from the shape [m]; <= 0 inside."""
    local = shape.to_local(points)
    if shape.kind == "box":
        return float(np.max(np.abs(local) - 0.5 * np.array(shape.size)))
    half = 0.5 * sum(shape.size[1:])
    offset = local - np.clip(local @ np.diag([0.0, 0.0, 1.0]), -half, half)
    return float(np.max(np.linalg.norm(offset, axis=1)) - shape.size[0])


def stl(path: Path, points: np.ndarray) -> Path:
    """An ASCII STL of triangles between successive points (N, 3)."""
    corners = (
        points[[i, (i + 1) % len(points), (i + 2) % len(points)]] for i in range(len(points))
    )
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle.tolist())
        + "endloop\nendfacet\n"
        for triangle in corners
    )
    path.write_text(f"solid s\n{facets}endsolid s\n")
    return path


def mesh(path: Path, seed: int | None = None) -> Shape:
    """A mesh at a random pose and scale; as it is without a seed."""
    if seed is None:
        return Shape("m", "mesh", (1.0, 1.0, 1.0), np.eye(3), np.zeros(3), path)
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng).as_matrix()
    scale = tuple((rng.uniform(0.5, 2.0, 3) * rng.choice([-1, 1], 3)).tolist())
    return Shape("m", "mesh", scale, turn, rng.uniform(-1, 1, 3), path)


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.stem)
@pytest.mark.parametrize("seed", [None, 1])
def test_every_vertex_is_inside(path: Path, seed: int | None) -> None:
    shape = mesh(path, seed)
    points = shape.translation + read_vertices(shape, where="m") @ shape.rotation.T
    around = enclosing_primitive(shape, where="m")
    assert -5e-4 < excess(around, points) <= 0.0, "inside, and some vertex near the surface"
    sides = np.ptp(points, axis=0)
    assert volume(around) <= np.prod(sides + 4e-6), "no larger than the box along the axes"


def test_vertices_are_those_of_coal_at_the_scale() -> None:
    scale = np.array([1.0, -2.0, 0.5])
    shape = Shape("m", "mesh", tuple(scale.tolist()), np.eye(3), np.zeros(3), MESHES[0])
    plain = np.array(coal.MeshLoader().load(str(MESHES[0]), np.ones(3)).vertices())
    np.testing.assert_allclose(read_vertices(shape, where="m"), plain * scale, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_turned_box_is_found_again(seed: int, tmp_path: Path) -> None:
    sides = np.array([0.3, 0.2, 0.1])
    corners = (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5) * sides
    turn = Rotation.random(rng=np.random.default_rng(seed))
    path = stl(tmp_path / "box.stl", turn.apply(corners)[[0, 1, 3, 2, 6, 7, 5, 4, 0, 2, 6, 3, 1]])
    around = enclosing_primitive(mesh(path), where="m")
    assert around.kind == "box"
    np.testing.assert_allclose(sorted(around.size), sorted(sides), rtol=0.02)


def test_a_slender_round_mesh_gets_a_capsule_and_a_ball_a_sphere(tmp_path: Path) -> None:
    directions = np.random.default_rng(0).normal(size=(2000, 3))
    ball = 0.05 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rod = ball + 0.1 * np.sign(ball[:, 2:]) * np.array([0.0, 0.6, 0.8])
    for points, length in ((rod, 0.2), (ball, 0.0)):
        around = enclosing_primitive(mesh(stl(tmp_path / f"{length}.stl", points)), where="m")
        assert around.kind in ("capsule", "sphere")
        assert around.size[0] == pytest.approx(0.05, rel=0.05)
        assert sum(around.size[1:]) == pytest.approx(length, abs=0.015), (
            "an axis within a few degrees"
        )
        assert excess(around, points) <= 1e-7, "the file's numbers are single precision"


def test_a_flat_mesh_gets_a_thin_box(tmp_path: Path) -> None:
    plate = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0.0]])
    around = enclosing_primitive(mesh(stl(tmp_path / "flat.stl", plate)), where="m")
    assert around.kind == "box"
    assert 0.0 < min(around.size) < 1e-5
    assert excess(around, plate) <= 0.0


@pytest.mark.parametrize("raw", [b"", b"solid s\nendsolid s\n", b"\x00" * 84, b"junk" * 50])
def test_a_mesh_that_cannot_be_read(raw: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bad.stl"
    path.write_bytes(raw)
    with pytest.raises(UrdfError, match=r"mesh"):
        enclosing_primitive(mesh(path), where="r.urdf: link 'a'")


def test_a_mesh_with_a_number_that_is_not_finite(tmp_path: Path) -> None:
    path = stl(tmp_path / "nan.stl", np.eye(3))
    path.write_text(path.read_text().replace("1.0", "nan"))
    with pytest.raises(UrdfError, match="mesh"):
        enclosing_primitive(mesh(path), where="m")
