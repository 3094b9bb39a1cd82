"""Timing laws: from 0 to 1, at rest at both ends, rates that are derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pivotgait.phases.timing import PROFILES, Profile, quintic, trapezoidal

Array = NDArray[np.float64]
DURATION = 1.6
BOTH = pytest.mark.parametrize("name", list(PROFILES))


def times(count: int, duration: float = DURATION) -> Array:
    return np.linspace(0.0, duration, count)


@BOTH
def test_ends(name: Profile) -> None:
    fraction, rate, acceleration = PROFILES[name](times(9), DURATION)
    assert fraction[0] == 0.0
    assert fraction[-1] == 1.0
    for derivative in (rate, acceleration):
        assert derivative[0] == 0.0
        assert derivative[-1] == 0.0


@BOTH
def test_fraction_never_falls_and_is_symmetric(name: Profile) -> None:
    fraction, rate, acceleration = PROFILES[name](times(1001), DURATION)
    assert (np.diff(fraction) > 0.0).all()
    assert (rate[1:-1] > 0.0).all()
    # one minus a number rounds at 1e-16; the rate and acceleration carry it on
    np.testing.assert_allclose(fraction + fraction[::-1], 1.0, atol=1e-15)
    np.testing.assert_allclose(rate, rate[::-1], atol=1e-13)
    smooth = np.abs(np.abs(times(1001) / DURATION - 0.5) - 0.25) > 1e-3  # not where it jumps
    np.testing.assert_allclose(acceleration[smooth], -acceleration[::-1][smooth], atol=1e-12)


@BOTH
def test_rates_are_derivatives(name: Profile) -> None:
    # 997 is prime, so that no sample meets the corners at a quarter and three quarters
    time, step = times(998)[1:-1], 1e-6
    law = PROFILES[name]
    (before, rate_before, _), (after, rate_after, _) = (
        law(time - step, DURATION),
        law(time + step, DURATION),
    )
    _, rate, acceleration = law(time, DURATION)
    # h^2 f''' / 6 < 2e-11 (f''' up to 60 / 1.6^3) and rounding 1e-16 / h = 1e-10
    np.testing.assert_allclose(rate, (after - before) / (2 * step), atol=1e-9)
    np.testing.assert_allclose(acceleration, (rate_after - rate_before) / (2 * step), atol=1e-9)


def test_quintic_is_smooth_where_it_meets_rest() -> None:
    _, _, acceleration = quintic(np.array([1e-9, DURATION - 1e-9]), DURATION)
    # 60 u / T^2 with u = 1e-9 / 1.6
    np.testing.assert_allclose(acceleration, [1.46e-8, -1.46e-8], rtol=0.01)


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5])
def test_area_of_the_trapezoid_is_one(share: float) -> None:
    time = times(4001)
    _, rate, acceleration = trapezoidal(time, DURATION, share)
    # the trapezoid rule is exact on straight pieces; corners are samples (0.1, 0.25, 0.5 of 4000)
    assert np.trapezoid(rate, time) == pytest.approx(1.0, abs=1e-12)
    assert rate.max() == pytest.approx(1.0 / (DURATION * (1.0 - share)), rel=1e-14)
    level = 1.0 / (share * (1.0 - share) * DURATION**2)
    found = np.unique(np.round(acceleration / level, 9))
    assert set(found) <= {-1.0, 0.0, 1.0}
    assert {-1.0, 1.0} <= set(found)


def test_trapezoid_tells_the_side_of_its_jumps() -> None:
    # the value after the jump, at whichever side of it rounding puts the sample
    ramp = 0.25 * DURATION
    for nudge in (-1e-12, 0.0, 1e-12):
        time = np.array([ramp, DURATION - ramp]) + nudge
        _, _, acceleration = trapezoidal(time, DURATION)
        assert acceleration[0] == 0.0
        assert acceleration[1] < 0.0


@BOTH
@pytest.mark.parametrize("factor", [1e-3, 0.5, 7.0, 1e3])
def test_a_longer_duration_only_stretches(name: Profile, factor: float) -> None:
    fraction, rate, acceleration = PROFILES[name](times(101), DURATION)
    long = PROFILES[name](times(101, factor * DURATION), factor * DURATION)
    # relative rounding of the time alone; atol: fraction and rates cross zero at the ends
    np.testing.assert_allclose(long[0], fraction, atol=1e-14)
    np.testing.assert_allclose(long[1] * factor, rate, atol=1e-13)
    np.testing.assert_allclose(long[2] * factor**2, acceleration, atol=1e-12)
