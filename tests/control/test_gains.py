"""Error dynamics (18)-(19) on the linear model, and the gains that follow from masses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pivotgait.control import AdmittanceGains, HybridGains, Reference
from pivotgait.control.apparent_mass import apparent_masses
from pivotgait.exceptions import InputError

Array = NDArray[np.float64]
GAINS = HybridGains()


def simulate(gains: HybridGains, mass: float, stiffness: float, period: float) -> Array:
    """Normal force of a tip against a spring under (14) and (17), sampled by its controller.

    The tip is ``mass``; tau = m z'' + f_d, f measured. Between cycles the spring acts on the mass,
    with a damper such as contacts have.
    """
    wanted, force, z, v = 1.0, [], 0.0, 0.0
    steps = 20
    aim = wanted / gains.contact_stiffness
    for _ in range(round(1.5 / period)):
        measured = stiffness * z
        pressing = wanted - measured - gains.impedance_damping * v
        pressing += gains.impedance_stiffness * (aim - z)
        drive = mass * pressing / gains.impedance_mass + wanted
        for _ in range(steps):
            v += (period / steps) * (drive - stiffness * z - 100.0 * v) / mass
            z += (period / steps) * v
        force.append(measured)
    return np.array(force)


@pytest.mark.parametrize("mass", [5e-3, 1e-2, 2e-2])
@pytest.mark.parametrize("stiffness", [2e3, 2e4])
def test_forces_settle_on_the_sampled_model(mass: float, stiffness: float) -> None:
    """(19) with the default gains: stable at 1 kHz; feed-forward divides the bias."""
    force = simulate(GAINS, mass, stiffness, 1e-3)
    # At rest m/k_m (1 - f + k_p (z_d - z)) + 1 - f = 0.
    share = mass / GAINS.impedance_mass
    slope = 1.0 + share * (1.0 + GAINS.impedance_stiffness / stiffness)
    rest = (1.0 + share * (1.0 + GAINS.impedance_stiffness / GAINS.contact_stiffness)) / slope
    assert force[-1] == pytest.approx(rest, rel=1e-3)
    assert np.ptp(force[-200:]) < 1e-3


def test_position_errors_decay_as_their_dynamics_say() -> None:
    """(18): e'' + K_v e' + K_p e = 0, whose roots are those of the damping ratio one."""
    roots = np.roots([1.0, GAINS.velocity, GAINS.position])
    assert GAINS.position_damping_ratio == pytest.approx(1.0)
    np.testing.assert_allclose(roots.real, -np.sqrt(GAINS.position), rtol=1e-6)
    assert GAINS.velocity * 1e-3 < 1.0  # far from the sampled bound of 2 at 1 kHz


@pytest.mark.parametrize("stiffness", [2e3, 2e4, 1e6])
def test_bias_of_the_impedance(stiffness: float) -> None:
    """k_m z'' = f_d - f + k_p (z_d - z) at rest with f = k_e z."""
    aim = 1.0 / GAINS.contact_stiffness
    z = (1.0 + GAINS.impedance_stiffness * aim) / (stiffness + GAINS.impedance_stiffness)
    assert GAINS.steady_force_ratio(stiffness) == pytest.approx(stiffness * z)


def test_a_right_estimate_has_no_bias() -> None:
    assert GAINS.steady_force_ratio(GAINS.contact_stiffness) == pytest.approx(1.0)
    half = HybridGains(contact_stiffness=1e4, impedance_stiffness=2e4)
    assert half.steady_force_ratio(2e4) == pytest.approx(1.5)


def test_the_default_fits_the_apparent_masses(reference: Reference) -> None:
    masses = apparent_masses(reference, reference.at(0.0))
    assert np.all((masses > 2e-3) & (masses < 0.05))
    assert np.all(GAINS.impedance_mass > 2.0 * masses)
    assert GAINS.impedance_damping == pytest.approx(
        2.0 * np.sqrt(GAINS.impedance_mass * GAINS.impedance_stiffness)
    )


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
@pytest.mark.parametrize(
    ("gains", "name"), [(HybridGains, "position"), (AdmittanceGains, "admittance")]
)
def test_gains_that_are_no_positive_numbers_are_refused(
    gains: type, name: str, value: float
) -> None:
    with pytest.raises(InputError, match=name):
        gains(**{name: value})
