"""What a sequence of finger gaits costs: turning, thin margins, way of the fingertips, time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pivotgait.exceptions import InputError


@dataclass(frozen=True)
class CostWeights:
    """What is weighed against what; a cost is a number without unit.

    Attributes:
        reorientation: of turning the tool [1/rad].
        margin: of a phase that ends at the edge of what contacts can hold; none for one that
            ends at least ``margin_wish_N`` inside it.
        margin_wish_N: depth of the grasp wished for: by so much every limit of the contact
            forces could be tightened at once [N].
        path: of the way of relocated fingertips [1/m].
        time: of the motion [1/s].

    Raises:
        InputError: for a weight below 0 or not finite, or a wish of 0.
    """

    reorientation: float = 2.0
    margin: float = 1.0
    margin_wish_N: float = 0.3
    path: float = 5.0
    time: float = 1.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"is {value}", where=name, mend="give a number of 0 or more")
        if self.margin_wish_N == 0.0:
            raise InputError("is 0", where="margin_wish_N", mend="give a force in newtons")

    def shortfall(self, depth_N: float) -> float:
        """How much of the depth wished for is missing, 0 to 1."""
        return float(np.clip(1.0 - depth_N / self.margin_wish_N, 0.0, 1.0))


@dataclass(frozen=True)
class Cost:
    """Of one phase or of several, before weighing.

    Attributes:
        reorientation_rad: angles by which the tool turns, added up [rad].
        shortfall: of the margins at the ends of phases, each 0 to 1, added up.
        path_m: ways of relocated fingertips, added up [m].
        time_s: of the motion [s].
    """

    reorientation_rad: float = 0.0
    shortfall: float = 0.0
    path_m: float = 0.0
    time_s: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(
            self.reorientation_rad + other.reorientation_rad,
            self.shortfall + other.shortfall,
            self.path_m + other.path_m,
            self.time_s + other.time_s,
        )

    def total(self, weights: CostWeights) -> float:
        """Weighed and added up."""
        return (
            weights.reorientation * self.reorientation_rad
            + weights.margin * self.shortfall
            + weights.path * self.path_m
            + weights.time * self.time_s
        )

    def as_json(self, weights: CostWeights) -> dict[str, float]:
        """Plain data for the command line."""
        return {
            "total": self.total(weights),
            "reorientation_deg": float(np.degrees(self.reorientation_rad)),
            "margin_shortfall": self.shortfall,
            "path_m": self.path_m,
            "time_s": self.time_s,
        }
