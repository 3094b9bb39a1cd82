"""Gains of the hybrid law, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite, sqrt

from pivotgait.exceptions import InputError


@dataclass(frozen=True)
class HybridGains:
    """Gains of eqs (12) and (14).

    The default follows from the apparent mass of a fingertip, 5 to 50 g for hands of human size
    (:func:`pivotgait.control.apparent_mass.apparent_masses`):

    * K_p: a tip of m = 5 g that is held by position resists with m K_p = 50 N/m, one of 20 g
      with 200 N/m. Much less lets a heavy tool roll; much more turns small errors of position
      into tangential forces that a lightly pressed finger cannot bear. K_v = 2 sqrt(K_p) is
      critical damping.
    * k_m is twice the largest apparent mass or more: the law divides forces by it, so that a
      smaller one asks for accelerations that a cycle's delay makes unstable; a much larger one
      hardly reacts.
    * k_v is critical damping of k_m and k_p: 2 sqrt(k_m k_p).
    * k_p is a twentieth of the stiffness of the contacts (20 kN/m), as the force at rest is
      wrong by k_p times the error of the position, and a softer one lets the tool drift.

    Attributes:
        position: K_p of coordinates by position [1/s^2].
        velocity: K_v of the same [1/s].
        impedance_mass: k_m [kg].
        impedance_damping: k_v [N s/m].
        impedance_stiffness: k_p [N/m].
        contact_stiffness: estimated k_e [N/m]; the finger aims f_nd / k_e into the tool.
    """

    position: float = 1e4
    velocity: float = 200.0
    impedance_mass: float = 0.1
    impedance_damping: float = 20.0
    impedance_stiffness: float = 1000.0
    contact_stiffness: float = 20e3

    def __post_init__(self) -> None:
        """Refuse gains that are no positive numbers."""
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not (isfinite(value) and value > 0.0):
                raise InputError(f"gain {entry.name} = {value}", mend="give a positive number")

    @property
    def position_damping_ratio(self) -> float:
        """Of the error dynamics (18): K_v / (2 sqrt(K_p))."""
        return self.velocity / (2.0 * sqrt(self.position))

    def impedance_damping_ratio(self, stiffness: float) -> float:
        """Of the error dynamics (19) against a contact of ``stiffness`` [N/m]."""
        total = self.impedance_stiffness + stiffness
        return self.impedance_damping / (2.0 * sqrt(self.impedance_mass * total))

    def steady_force_ratio(self, stiffness: float) -> float:
        """f_n / f_nd at rest against a contact of ``stiffness`` k_e [N/m].

        (1 + k_p / k_e estimated) / (1 + k_p / k_e): one only where the estimate is right.
        """
        return (1.0 + self.impedance_stiffness / self.contact_stiffness) / (
            1.0 + self.impedance_stiffness / stiffness
        )
