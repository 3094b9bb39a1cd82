"""MuJoCo's parameters of a contact give the spring and damper asked for."""

from __future__ import annotations

import pytest

from pivotgait.validation.spring_contact import IMPEDANCES, soft_constraint

LIGHT, HEAVY = 100.0, 0.05
"""Inverse masses of a distal link and of a box [1/kg]."""


@pytest.mark.parametrize("stiffness", [500.0, 2e4, 1e5])
@pytest.mark.parametrize("damping", [10.0, 100.0])
@pytest.mark.parametrize("step", [2e-3, 2.5e-4])
@pytest.mark.parametrize("inverse_mass", [LIGHT, HEAVY])
def test_a_step_is_implicit_euler(
    stiffness: float, damping: float, step: float, inverse_mass: float
) -> None:
    """Solve MuJoCo's one-contact problem and put its answer into the spring's equation."""
    contact = soft_constraint(stiffness, damping, step, inverse_mass)
    impedance = contact.solimp[0]
    assert contact.solimp[:2] == (impedance, impedance)
    k, b = (-value / impedance for value in contact.solref)
    softness = inverse_mass * (1.0 - impedance) / impedance
    depth, speed, free = -1e-4, -0.02, -9.81
    # MuJoCo: a + R f = -b v - k r, where a = a0 + A f
    force = (-b * speed - k * depth - free) / (inverse_mass + softness)
    after = speed + step * (free + inverse_mass * force)
    spring = -stiffness * (depth + step * after) - damping * after
    assert force == pytest.approx(spring, rel=1e-9)


@pytest.mark.parametrize(
    ("stiffness", "damping", "inverse_mass"), [(1e-3, 0.0, 1e-3), (1e9, 0.0, 100.0)]
)
def test_what_cannot_be_had_keeps_its_stiffness(
    stiffness: float, damping: float, inverse_mass: float
) -> None:
    """Beyond MuJoCo's impedances the force at rest is still K times the depth."""
    contact = soft_constraint(stiffness, damping, 1e-3, inverse_mass)
    impedance = contact.solimp[0]
    assert impedance == pytest.approx(IMPEDANCES[stiffness > 1.0])
    softness = inverse_mass * (1.0 - impedance) / impedance
    k, b = (-value / impedance for value in contact.solref)
    assert k / softness == pytest.approx(stiffness)
    assert b * 1e-3 <= 1.0 + 1e-9  # more than a step's worth of damping would overshoot


def test_hard_contacts_ask_nothing_of_stiffness_or_damping() -> None:
    assert soft_constraint(None, 0.0, 1e-3, LIGHT) == soft_constraint(None, 9.0, 1e-3, HEAVY)
