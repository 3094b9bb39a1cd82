"""Samples are dense enough where the trapezoid rule joins them, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.frozen import Array
from pivotgait.planning.time_scaling import _resolved
from pivotgait.planning.trajectory import JointTrajectory
from pivotgait.plans import ToolMotion

STILL = np.zeros((0, 3))
NO_TOOL = ToolMotion(STILL, np.zeros((0, 4)), STILL, STILL, STILL, STILL)


def trajectory(time: Array, q: Array, v: Array, a: Array) -> JointTrajectory:
    return JointTrajectory(
        time=time,
        q=q[:, None],
        v=v[:, None],
        a=a[:, None],
        s=np.zeros(len(time)),
        tool=NO_TOOL,
        speed_share=0.0,
        acceleration_share=0.0,
        drift=0.0,
    )


def wave(count: int, turns: float, size: float = 1.0) -> JointTrajectory:
    """A sine that swings ``turns`` times in a second."""
    time, omega = np.linspace(0.0, 1.0, count), 2.0 * np.pi * turns
    phase = omega * time
    growth = -size * omega**2 * np.sin(phase)
    return trajectory(time, size * np.sin(phase), size * omega * np.cos(phase), growth)


@pytest.mark.parametrize("turns", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("size", [1e-3, 1.0])
def test_twenty_samples_in_a_swing_are_enough(turns: float, size: float) -> None:
    assert _resolved(wave(int(20 * turns) + 1, turns, size))


@pytest.mark.parametrize("count", [12, 25, 51])
def test_a_swing_between_samples_is_seen(count: int) -> None:
    """The samples of a sine that swings as often as there are steps: they see none of it."""
    assert not _resolved(wave(count, float(count - 1)))


@pytest.mark.parametrize("seed", range(3))
def test_constant_acceleration_within_each_of_two_pieces(seed: int) -> None:
    """The bound's own case: a jump of the acceleration in the middle of a step is allowed."""
    rng, time = np.random.default_rng(seed), np.linspace(0.0, 1.0, 21)
    speed, first, second = rng.normal(size=3)
    later = np.maximum(time - 0.525, 0.0)
    a = np.where(time < 0.525, first, second)
    v = speed + first * time + (second - first) * later
    q = speed * time + 0.5 * first * time**2 + 0.5 * (second - first) * later**2
    assert _resolved(trajectory(time, q, v, a))


@pytest.mark.parametrize("field", ["q", "v"])
def test_a_sample_that_is_off_is_seen(field: str) -> None:
    """By a micrometre or a microradian, in a motion of constant acceleration."""
    time = np.linspace(0.0, 1.0, 21)
    arrays = {"q": 0.5 * time**2, "v": time.copy(), "a": np.ones(21)}
    assert _resolved(trajectory(time, **arrays))
    arrays[field][9] += 1e-6
    assert not _resolved(trajectory(time, **arrays))


def test_noise_of_rounding_is_none() -> None:
    noise = 1e-11 * np.random.default_rng(0).normal(size=(2, 41))
    still = np.zeros(41)
    time = np.linspace(0.0, 1.0, 41)
    assert _resolved(trajectory(time, noise[0], noise[1], still))
