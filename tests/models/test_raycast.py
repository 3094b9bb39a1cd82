"""Laws of the ray casts and of the covering balls."""

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pivotgait.models.coal_shapes import ball_distance, coal_object
from pivotgait.models.raycast import EMPTY, inside_span, outward_normal
from pivotgait.models.shape import Shape
from pivotgait.models.support import support_balls

seeds = st.integers(0, 2**32 - 1)
SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}


def random_shape(generator: np.random.Generator, kind: str) -> Shape:
    size = tuple(generator.uniform(0.01, 0.1, SIZES[kind]).tolist())
    rotation = Rotation.random(rng=generator).as_matrix()
    return Shape("s", kind, size, rotation, generator.uniform(-0.1, 0.1, 3))  # type: ignore[arg-type]


def unit(generator: np.random.Generator) -> np.ndarray:
    vector = generator.normal(size=3)
    return vector / np.linalg.norm(vector)


def contains(shape: Shape, point: np.ndarray) -> bool:
    x, y, z = shape.to_local(point)
    if shape.kind == "box":
        return bool(np.all(2.0 * np.abs([x, y, z]) < shape.size))
    if shape.kind == "sphere":
        return bool(np.hypot(np.hypot(x, y), z) < shape.size[0])
    beyond = abs(z) - shape.size[1] / 2.0
    if shape.kind == "cylinder":
        return bool(beyond < 0.0 and np.hypot(x, y) < shape.size[0])
    return bool(np.hypot(np.hypot(x, y), max(beyond, 0.0)) < shape.size[0])


@pytest.mark.parametrize("kind", SIZES)
@given(seed=seeds)
@settings(max_examples=100, deadline=None)
def test_span_is_the_stretch_inside(kind: str, seed: int) -> None:
    generator = np.random.default_rng(seed)
    shape, direction = random_shape(generator, kind), unit(generator)
    origin = shape.translation + generator.uniform(-0.05, 0.05, 3) - 0.3 * direction
    low, high = inside_span(shape, origin, direction)
    if (low, high) == EMPTY:
        assert not any(contains(shape, origin + t * direction) for t in np.linspace(-1.0, 1.0, 201))
        return
    step = 1e-9
    for t, expected in ((low, True), (high, False)):
        if high - low > 1e-6:
            assert contains(shape, origin + (t + step) * direction) == expected
            assert contains(shape, origin + (t - step) * direction) != expected


@pytest.mark.parametrize("kind", SIZES)
@given(seed=seeds)
@settings(max_examples=50, deadline=None)
def test_normal_is_the_direction_coal_measures(kind: str, seed: int) -> None:
    generator = np.random.default_rng(seed)
    shape, direction = random_shape(generator, kind), unit(generator)
    point = shape.translation + inside_span(shape, shape.translation, direction)[1] * direction
    normal = outward_normal(shape, point)
    if normal is None:
        return
    distance, on_shape, on_ball = ball_distance(shape, point + 2e-3 * normal, 1e-3)
    assert distance == pytest.approx(1e-3, abs=1e-6)
    np.testing.assert_allclose((on_ball - on_shape) / distance, normal, rtol=0, atol=2e-3)


def test_edges_have_no_normal() -> None:
    box = Shape("b", "box", (0.2, 0.2, 0.2), np.eye(3), np.zeros(3))
    can = Shape("c", "cylinder", (0.1, 0.2), np.eye(3), np.zeros(3))
    assert outward_normal(box, np.array([0.1, 0.1, 0.0])) is None
    assert outward_normal(can, np.array([0.1, 0.0, 0.1])) is None
    assert outward_normal(box, np.array([0.1, 0.09, 0.0])) is not None


@pytest.mark.parametrize("kind", SIZES)
@given(seed=seeds)
@settings(max_examples=50, deadline=None)
def test_covering_balls_reach_as_low_as_the_shape(kind: str, seed: int) -> None:
    generator = np.random.default_rng(seed)
    shape, up = random_shape(generator, kind), unit(generator)
    centres, radii = support_balls(shape)
    lowest = float(np.min(centres @ up - radii))
    plane = coal.CollisionObject(coal.Halfspace(up, -1.0), coal.Transform3s())
    result = coal.DistanceResult()
    distance = coal.distance(coal_object(shape), plane, coal.DistanceRequest(), result)
    measured = distance - 1.0
    slack = 0.006 * shape.size[0] if kind == "cylinder" else 1e-9
    assert measured - slack <= lowest <= measured + 1e-9


def test_meshes_are_refused() -> None:
    mesh = Shape("m", "mesh", (1.0, 1.0, 1.0), np.eye(3), np.zeros(3))
    with pytest.raises(ValueError, match="not a primitive"):
        inside_span(mesh, np.zeros(3), np.array([1.0, 0.0, 0.0]))
    with pytest.raises(ValueError, match="not a primitive"):
        support_balls(mesh)
    with pytest.raises(ValueError, match="not a primitive"):
        coal_object(mesh)


def test_coal_never_sees_a_pose_that_is_not_finite() -> None:
    ball = Shape("s", "sphere", (0.1,), np.eye(3), np.zeros(3))
    with pytest.raises(ValueError, match="not finite"):
        ball_distance(ball, np.array([np.nan, 0.0, 0.0]), 0.01)
