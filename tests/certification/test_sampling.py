"""Both honest kinds of sampling pass; a dishonest one does not, by the amount it lies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.certification.limits import LIMITS
from pivotgait.certification.sampling import check_sampling
from pivotgait.plans import Phase, ToolMotion


def excesses(time, rotation, omega, sigma) -> dict[str, float]:
    zero = np.zeros((len(time), 3))
    motion = ToolMotion(zero, rotation.as_quat(), zero, omega, zero, sigma)
    phase = Phase("00_lift", "lift", "", time, motion, {})
    return {found.what: found.value for found in check_sampling(phase)}


def passes(*motion) -> bool:
    return all(LIMITS[what].holds(value) for what, value in excesses(*motion).items())


def quintic(samples: int, angle: float = 1.0, duration: float = 0.5):
    time = np.linspace(0.0, duration, samples)
    s = time / duration
    axis = np.array([[2.0, -1.0, 2.0]]) / 3.0
    course = angle * (10 * s**3 - 15 * s**4 + 6 * s**5)
    rate = angle * (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
    surge = angle * (60 * s - 180 * s**2 + 120 * s**3) / duration**2
    return (
        time,
        Rotation.from_rotvec(course[:, None] * axis),
        rate[:, None] * axis,
        surge[:, None] * axis,
    )


def coning(samples: int):
    """A turning axis: R = exp(a z) exp(b x), w = a' z + b' exp(a z) x."""
    time = np.linspace(0.0, 1.0, samples)
    a, b = 2.0 * time, 0.7 * np.sin(time)
    rotation = Rotation.from_euler("Z", a[:, None]) * Rotation.from_euler("X", b[:, None])
    x = np.stack((np.cos(a), np.sin(a), 0 * a), axis=1)
    y = np.stack((-np.sin(a), np.cos(a), 0 * a), axis=1)
    b1, b2 = 0.7 * np.cos(time)[:, None], -0.7 * np.sin(time)[:, None]
    omega = b1 * x + [0.0, 0.0, 2.0]
    return time, rotation, omega, b2 * x + 2.0 * b1 * y


def trapezoid(samples: int, ramp: float):
    time = np.linspace(0.0, 1.0, samples)
    rate = np.clip(np.minimum(time, 1.0 - time) / ramp, 0.0, 1.0)
    surge = np.where(time < ramp, 1.0 / ramp, np.where(time > 1.0 - ramp, -1.0 / ramp, 0.0))
    late = (1.0 - ramp) - 0.5 * (1.0 - time) ** 2 / ramp
    early = np.where(time < ramp, 0.5 * time**2 / ramp, time - 0.5 * ramp)
    course = np.where(time > 1.0 - ramp, late, early)
    axis = np.array([[0.0, 1.0, 0.0]])
    return (
        time,
        Rotation.from_rotvec(course[:, None] * axis),
        rate[:, None] * axis,
        surge[:, None] * axis,
    )


def euler(samples: int, seed: int):
    rng = np.random.default_rng(seed)
    time = np.concatenate(([0.0], np.cumsum(rng.uniform(0.005, 0.05, samples - 1))))
    sigma = rng.normal(size=(samples, 3)) * 5.0
    omega, rotation = np.zeros((samples, 3)), [Rotation.random(rng=rng)]
    for k, h in enumerate(np.diff(time)):
        omega[k + 1] = omega[k] + h * sigma[k]
        rotation.append(Rotation.from_rotvec(h * omega[k]) * rotation[-1])
    return time, Rotation.concatenate(rotation), omega, sigma


@pytest.mark.parametrize("samples", [6, 9, 16, 40, 300])
def test_quintic_passes(samples: int) -> None:
    assert passes(*quintic(samples))


@pytest.mark.parametrize("samples", [20, 21, 100])
def test_turning_axis_passes(samples: int) -> None:
    assert passes(*coning(samples))


@pytest.mark.parametrize("ramp", [0.05, 0.1, 0.123, 0.2, 0.25, 1 / 3, 0.49, 0.5])
@pytest.mark.parametrize("samples", [21, 22, 64])
def test_trapezoid_with_jumps_anywhere_in_a_step_passes(samples: int, ramp: float) -> None:
    assert passes(*trapezoid(samples, ramp))


@pytest.mark.parametrize("seed", range(5))
def test_forward_euler_passes_exactly_with_uneven_steps(seed: int) -> None:
    assert max(excesses(*euler(30, seed)).values()) < 1e-12


@pytest.mark.parametrize("motion", [quintic(60), coning(60), trapezoid(60, 0.3), euler(60, 1)])
def test_wrong_rate_is_seen(motion) -> None:
    """An angular velocity 1 % too large contradicts the orientations."""
    time, rotation, omega, sigma = motion
    assert not passes(time, rotation, 1.01 * omega, 1.01 * sigma)


@pytest.mark.parametrize("motion", [quintic(60), coning(60), euler(60, 1)])
def test_wrong_acceleration_is_seen(motion) -> None:
    time, rotation, omega, sigma = motion
    offset = np.full_like(sigma, 0.2 * np.abs(sigma).max())
    assert excesses(time, rotation, omega, sigma + offset)["rate_excess_rad_s"] > 1e-4


def test_velocity_in_the_tool_frame_is_seen() -> None:
    time, rotation, omega, sigma = coning(60)
    assert not passes(time, rotation, rotation.inv().apply(omega), rotation.inv().apply(sigma))


def test_half_angle_slip_is_seen() -> None:
    """The quaternion of h w instead of h w / 2 turns twice as far."""
    time, rotation, omega, sigma = euler(30, 2)
    doubled = [rotation[0]]
    for h, rate in zip(np.diff(time), omega, strict=False):
        doubled.append(Rotation.from_rotvec(2.0 * h * rate) * doubled[-1])
    assert not passes(time, Rotation.concatenate(doubled), omega, sigma)
