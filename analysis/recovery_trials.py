"""Trials whose world is farther from the plan than a scene draws it, for study 14."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pivotgait.models import Robot, Scene
from pivotgait.validation import TrialOptions
from pivotgait.validation.perturbation import Perturbation


@dataclass(frozen=True)
class DisturbedOptions(TrialOptions):
    """Trials in which a seed's draw is enlarged, and the fingers are more slippery.

    Attributes:
        errors: factor of every error of the draw (:meth:`Perturbation.enlarged`).
        friction: factor of the fingers' friction besides.
    """

    errors: float = 1.0
    friction: float = 1.0

    def perturbation(self, scene: Scene, robot: Robot, seed: int) -> Perturbation:
        """What is otherwise in the trial of a seed."""
        draw = super().perturbation(scene, robot, seed)
        larger = draw if self.errors == 1.0 else draw.enlarged(self.errors)
        scale = self.friction * larger.finger_friction_scale
        return replace(larger, finger_friction_scale=scale)
