"""A spring-damper contact in the terms of MuJoCo's soft constraints."""

from __future__ import annotations

from dataclasses import dataclass

IMPEDANCES = (1e-4, 0.9999)
"""Least and greatest impedance that MuJoCo accepts."""
_HARD_IMPEDANCE = 0.99


@dataclass(frozen=True)
class SoftConstraint:
    """Parameters of a contact in MuJoCo, constant over the depth.

    Attributes:
        solref: (-stiffness, -damping) of the reference acceleration, scaled by the impedance.
        solimp: impedance at the surface and below, and the (idle) width between them.
    """

    solref: tuple[float, float]
    solimp: tuple[float, float, float]


def soft_constraint(
    stiffness: float | None, damping: float, step_s: float, inverse_mass: float
) -> SoftConstraint:
    """A contact point of K = ``stiffness`` [N/m] and B = ``damping`` [N s/m].

    An implicit Euler step h of the spring-damper gives, for depth r < 0, normal velocity v and
    the acceleration a of the step to come,

        f = -K (r + h (v + h a)) - B (v + h a) = (-k r - b v - a) / R,
        R = 1 / (h (B + h K)),  k = K R,  b = 1 / h,

    which is MuJoCo's constraint with regularisation R, and what Bullet makes of K and B. MuJoCo
    takes R = A (1 - d) / d for an impedance d and its estimate A of the inverse mass at the
    contact, and k = -solref[0] / d, b = -solref[1] / d where d is constant: hence d = A / (A + R).
    K and B are thus kept whatever the bodies weigh; where d would leave its range, K is.

    Args:
        stiffness: None for a hard contact, which needs one step back to the surface.
        damping: without effect on a hard contact.
        step_s: of the integration, h [s].
        inverse_mass: A, the sum of both bodies' ``body_invweight0`` [1/kg].
    """
    if stiffness is None:
        # critically damped, with the shortest time constant the step allows
        rate = 1.0 / (2.0 * step_s)
        return _constant(rate**2, 2.0 * rate, _HARD_IMPEDANCE)
    slope = damping + step_s * stiffness
    softness = 1.0 / (step_s * slope)
    low, high = IMPEDANCES
    impedance = min(max(inverse_mass / (inverse_mass + softness), low), high)
    softness = inverse_mass * (1.0 - impedance) / impedance
    return _constant(stiffness * softness, min(slope * softness, 1.0 / step_s), impedance)


def _constant(k: float, b: float, impedance: float) -> SoftConstraint:
    return SoftConstraint((-k * impedance, -b * impedance), (impedance, impedance, 1e-3))
