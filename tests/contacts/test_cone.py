"""Friction cones: the exact one, the pyramid inside it, and the margin to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pivotgait.contacts import cone_margin, contact_frame, friction_margin, inner_pyramid
from pivotgait.contacts.cone import split_force

Array = NDArray[np.float64]
ROUNDING = 1e-13
"""Forces below 100 N, sums of a few products: some hundred roundings of 1e-16 relative."""

FRICTION = st.floats(0.01, 2.0)
FACETS = st.integers(3, 40)
UP = np.array([0.0, 0.0, 1.0])


@st.composite
def unit_vectors(draw: st.DrawFn) -> Array:
    polar, around = draw(st.floats(0.0, np.pi)), draw(st.floats(0.0, 2.0 * np.pi))
    flat = np.sin(polar)
    return np.array([flat * np.cos(around), flat * np.sin(around), np.cos(polar)])


@st.composite
def forces(draw: st.DrawFn) -> Array:
    component = st.floats(-10.0, 10.0)
    return np.array([draw(component) for _ in range(3)])


@given(force=forces(), friction=FRICTION, facets=FACETS)
def test_inner_pyramid_is_inside_the_exact_cone(force: Array, friction: float, facets: int) -> None:
    # a point of the pyramid: lift an arbitrary force until every facet is kept
    rows = inner_pyramid(friction, facets)
    need = (rows[:, :2] @ force[:2]) / -rows[:, 2]
    inside = np.array([force[0], force[1], max(float(need.max()), 0.0)])
    assert (rows @ inside <= ROUNDING).all()
    assert cone_margin(inside, UP, friction) >= -ROUNDING * max(1.0, 1.0 / friction)


@given(friction=FRICTION, facets=FACETS)
def test_inner_pyramid_touches_the_cone_at_its_edges_only(friction: float, facets: int) -> None:
    rows = inner_pyramid(friction, facets)
    for place in range(facets):
        # an edge is where two neighbouring facets meet
        edge = np.cross(rows[place - 1], rows[place])
        edge /= edge[2]
        assert cone_margin(edge, UP, friction) == pytest.approx(0.0, abs=1e-12)
        middle = np.append(-rows[place, 2] * rows[place, :2], 1.0)
        depth = friction * (1.0 - np.cos(np.pi / facets))
        assert (rows @ middle <= ROUNDING).all()
        assert cone_margin(middle, UP, friction) == pytest.approx(depth, abs=ROUNDING)


def test_inner_pyramid_grows_towards_the_cone() -> None:
    force = np.array([0.499, 0.0, 1.0])  # just inside mu = 0.5, half way between two edges
    turned = [
        Rotation.from_rotvec(np.pi / facets * UP).as_matrix() @ force for facets in (4, 8, 256)
    ]
    kept = [
        bool((inner_pyramid(0.5, facets) @ each <= 0.0).all())
        for facets, each in zip((4, 8, 256), turned, strict=True)
    ]
    assert kept == [False, False, True]


@pytest.mark.parametrize(
    ("friction", "facets"), [(0.5, 2), (0.5, 0), (0.0, 8), (-0.3, 8), (float("nan"), 8)]
)
def test_inner_pyramid_refuses_what_has_no_pyramid(friction: float, facets: int) -> None:
    with pytest.raises(ValueError, match="facets >= 3 and friction > 0"):
        inner_pyramid(friction, facets)


@given(force=forces(), normal=unit_vectors(), friction=FRICTION, angle=st.floats(-10.0, 10.0))
def test_margins_do_not_change_when_the_force_turns_about_the_normal(
    force: Array, normal: Array, friction: float, angle: float
) -> None:
    turned = Rotation.from_rotvec(angle * normal).as_matrix() @ force
    before, after = cone_margin(force, normal, friction), cone_margin(turned, normal, friction)
    assert after == pytest.approx(float(before), abs=1e-12)


@given(force=forces(), normal=unit_vectors(), friction=FRICTION, scale=st.floats(0.0, 100.0))
def test_the_cone_is_a_cone(force: Array, normal: Array, friction: float, scale: float) -> None:
    scaled = cone_margin(scale * force, normal, friction)
    assert scaled == pytest.approx(scale * float(cone_margin(force, normal, friction)), abs=1e-10)


@given(one=forces(), other=forces(), normal=unit_vectors(), friction=FRICTION)
def test_the_cone_is_convex(one: Array, other: Array, normal: Array, friction: float) -> None:
    # the margin is concave and homogeneous, hence superadditive
    apart = cone_margin(one, normal, friction) + cone_margin(other, normal, friction)
    assert cone_margin(one + other, normal, friction) >= apart - ROUNDING


@given(force=forces(), normal=unit_vectors())
def test_split_is_pythagoras(force: Array, normal: Array) -> None:
    along, across = split_force(force, normal)
    assert along**2 + across**2 == pytest.approx(float(force @ force), abs=1e-11)
    assert along == pytest.approx(float((contact_frame(normal).T @ force)[2]), abs=ROUNDING)


@given(force=forces(), normal=unit_vectors(), friction=FRICTION)
def test_friction_margin_is_in_0_1_exactly_inside_the_cone(
    force: Array, normal: Array, friction: float
) -> None:
    margin = float(friction_margin(force, normal, friction))
    slack = float(cone_margin(force, normal, friction))
    along, _ = split_force(force, normal)
    if along <= 0.0:
        assert np.isnan(margin)
        return
    assume(abs(slack) > 1e-12)  # on the cone itself rounding decides
    assert margin <= 1.0
    assert (margin > 0.0) == (slack > 0.0)
    assert margin == pytest.approx(slack / (friction * float(along)), rel=1e-9, abs=1e-12)


def test_friction_margin_of_special_forces() -> None:
    rows = np.array([[0.0, 0.0, 2.0], [0.6, 0.8, 2.0], [0.0, 0.5, 2.0], [0, 0, 0], [0, 0, -1.0]])
    expected = [1.0, 0.0, 0.5, np.nan, np.nan]  # straight, on the cone, half way, none, pulling
    np.testing.assert_allclose(friction_margin(rows, UP, 0.5), expected, atol=1e-15)


def test_friction_margin_of_next_to_no_normal_force_is_minus_infinity() -> None:
    # the quotient overflows; it did with a warning, which is an error in this suite
    assert friction_margin(np.array([0.0, 2.0, 1e-308]), UP, 1.0) == -np.inf


def test_margins_broadcast_over_samples_and_contacts() -> None:
    rng = np.random.default_rng(2)
    force, friction = rng.normal(size=(7, 3, 3)), np.array([0.3, 0.5, 0.8])
    normal = rng.normal(size=(7, 3, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    whole = cone_margin(force, normal, friction)
    assert whole.shape == (7, 3)
    alone = cone_margin(force[4, 1], normal[4, 1], friction[1])
    assert whole[4, 1] == pytest.approx(float(alone), abs=1e-15)
