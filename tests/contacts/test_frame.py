"""Contact frames are right-handed orthonormal frames on the normal, wherever it points."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pivotgait.contacts import contact_frame

Array = NDArray[np.float64]
ROUNDING = 1e-14
"""Sums of products of numbers below 2 in double precision: tens of roundings of 2e-16."""

COORDINATE = st.floats(-1.0, 1.0, allow_nan=False)


def assert_is_frame_of(frame: Array, normal: Array) -> None:
    identity = np.broadcast_to(np.eye(3), frame.shape)
    np.testing.assert_allclose(np.swapaxes(frame, -1, -2) @ frame, identity, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.det(frame), 1.0, atol=ROUNDING)
    np.testing.assert_array_equal(frame[..., 2], normal)


@given(st.tuples(COORDINATE, COORDINATE, COORDINATE))
def test_frame_is_orthonormal_and_right_handed_on_the_normal(vector: tuple[float, ...]) -> None:
    length = float(np.linalg.norm(vector))
    assume(length > 1e-3)
    normal = np.array(vector) / length
    assert_is_frame_of(contact_frame(normal), normal)


@pytest.mark.parametrize("axis", np.vstack((np.eye(3), -np.eye(3))))
def test_frame_on_the_axes(axis: Array) -> None:
    assert_is_frame_of(contact_frame(axis), axis)


@pytest.mark.parametrize("pole", [-1.0, 1.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-300, 1e-162, 1e-12, 1e-8, 1e-4, 1e-2])
def test_frame_keeps_its_precision_beside_the_poles(pole: float, tilt: float) -> None:
    # the formula divides by sign + n_z: without its branch it would divide by zero at n_z = -1
    around = np.linspace(0.0, 2.0 * np.pi, 13)
    flat = np.sin(tilt) * np.stack((np.cos(around), np.sin(around)), axis=-1)
    normal = np.column_stack((flat, np.full(13, pole * np.cos(tilt))))
    assert_is_frame_of(contact_frame(normal), normal)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_frame_changes_no_faster_than_the_normal(side: float) -> None:
    # a quarter circle from the equator to the pole of one hemisphere, sampled finely
    angle = np.linspace(1e-9, np.pi / 2, 2001)
    meridian = np.array([0.6, 0.8])
    up = side * np.sin(angle)
    normal = np.column_stack((np.cos(angle)[:, None] * meridian, up))
    change = np.linalg.norm(np.diff(contact_frame(normal), axis=0), axis=(1, 2))
    # one turn by d moves a rotation matrix by sqrt(2) d in Frobenius norm; d / |1 + n_z| <= d
    # bounds the twist about the normal, so that 2 sqrt(2) d is never exceeded
    assert change.max() <= 2.0 * np.sqrt(2.0) * np.diff(angle)[0]


def test_stacked_normals_give_stacked_frames() -> None:
    normal = np.random.default_rng(1).normal(size=(4, 5, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    frames = contact_frame(normal)
    assert frames.shape == (4, 5, 3, 3)
    assert_is_frame_of(frames, normal)
    np.testing.assert_array_equal(frames[2, 3], contact_frame(normal[2, 3]))
