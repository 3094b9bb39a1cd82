"""The time law, and the least duration under it."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pivotgait.planning.smoothing import SmoothPath
from pivotgait.planning.time_scaling import least_duration, time_law


def test_the_law_goes_from_rest_to_rest() -> None:
    tau = np.linspace(0.0, 1.0, 2001)
    u, rate, change = time_law(tau)
    assert (u[0], u[-1]) == (0.0, pytest.approx(1.0))
    for ends in (rate, change):
        np.testing.assert_allclose(ends[[0, -1]], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.gradient(u, tau)[1:-1], rate[1:-1], atol=1e-5)
    np.testing.assert_allclose(np.gradient(rate, tau)[1:-1], change[1:-1], atol=1e-4)
    assert np.all(rate[1:-1] > 0.0)


def line(length: float) -> SmoothPath:
    nodes = np.linspace(0.0, 1.0, 12)
    values = np.column_stack((length * nodes, np.zeros(12), nodes))
    return SmoothPath(make_interp_spline(nodes, values, k=5), nodes)


@pytest.mark.parametrize("length", [0.1, 1.0, -3.0])
def test_a_straight_line_takes_the_quintic_s_own_time(length: float) -> None:
    far = abs(length)
    by_speed = least_duration(line(length), np.array([2.0, 2.0]), np.full(2, 1e9))
    assert by_speed == pytest.approx(1.875 * far / 2.0, rel=1e-3)
    by_acceleration = least_duration(line(length), np.full(2, 1e9), np.array([5.0, 5.0]))
    assert by_acceleration == pytest.approx(np.sqrt(10.0 / np.sqrt(3.0) * far / 5.0), rel=1e-3)
