"""What is otherwise in a trial than in its plan, drawn from one seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models.robot import Robot
from pivotgait.models.validation_config import ValidationConfig

_SIZE_STREAM = 2
"""Keeps the size of the errors apart from the draw itself, which uses the seed alone."""


@dataclass(frozen=True, eq=False)
class ForceSensing(FrozenArrays):
    """Errors of the fingertips' force readings.

    Attributes:
        gain: reading over true force, by finger.
        turn: (3, 3) reading <- true direction, by finger; about an axis fixed in the world.
        noise: standard deviation of each component [N].
        delay_s: [s].
    """

    gain: Mapping[str, float]
    turn: Mapping[str, Array]
    noise: float = 0.0
    delay_s: float = 0.0


@dataclass(frozen=True, eq=False)
class Perturbation(FrozenArrays):
    """One draw.

    Attributes:
        seed: that it was drawn from, and from which the sensors' noise follows.
        laid: (3,) x and y [m] and yaw [rad] by which the tool lies elsewhere; planned for.
        offset: (3,) x and y of the centre of mass [m] and yaw about it [rad] by which the tool
            is elsewhere than planner and controller believe.
        mass_scale: of the tool's mass and inertia.
        finger_friction_scale: of all fingertips.
        table_friction_scale: of the table.
        handle_growth: by which the handle is wider [m].
        joint_friction: (nv,) dry friction [N m] or [N].
        sensing: of forces.
    """

    seed: int
    laid: Array
    offset: Array
    mass_scale: float
    finger_friction_scale: float
    table_friction_scale: float
    handle_growth: float
    joint_friction: Array
    sensing: ForceSensing

    @classmethod
    def none(cls, robot: Robot, seed: int = 0) -> Perturbation:
        """The world just as planned, and perfect sensors."""
        exact = ForceSensing(
            gain=dict.fromkeys(robot.fingers, 1.0),
            turn={name: np.eye(3) for name in robot.fingers},
        )
        return cls(
            seed=seed,
            laid=np.zeros(3),
            offset=np.zeros(3),
            mass_scale=1.0,
            finger_friction_scale=1.0,
            table_friction_scale=1.0,
            handle_growth=0.0,
            joint_friction=np.zeros(robot.nv),
            sensing=exact,
        )

    @classmethod
    def draw(cls, config: ValidationConfig, robot: Robot, seed: int) -> Perturbation:
        """A draw from the scene's distributions; the same seed gives the same draw."""
        rng = np.random.default_rng(seed)

        def about(centre: float, half_width: float) -> float:
            return float(centre + half_width * rng.uniform(-1.0, 1.0))

        def placed(metres: float, degrees: float) -> Array:
            return np.array([about(0, metres), about(0, metres), about(0, np.radians(degrees))])

        return cls(
            seed=seed,
            laid=placed(config.laid_m, config.laid_yaw_deg),
            offset=placed(config.pose_error_m, config.pose_error_deg),
            mass_scale=about(1.0, config.mass_share),
            finger_friction_scale=about(1.0, config.friction_share),
            table_friction_scale=about(1.0, config.friction_share),
            handle_growth=about(0.0, config.handle_width_m),
            joint_friction=config.joint_friction_share
            * rng.uniform(size=robot.nv)
            * _finite(robot),
            sensing=ForceSensing(
                gain={name: about(1.0, config.force_gain_share) for name in robot.fingers},
                turn={name: _turn(rng, config.force_direction_deg) for name in robot.fingers},
                noise=config.force_noise_N,
                delay_s=config.force_delay_s,
            ),
        )

    def enlarged(self, factor: float) -> Perturbation:
        """The same draw with every error ``factor`` times as large.

        Where the tool lies is planned for, so no error: it stays.

        Raises:
            InputError: a factor that is negative or leaves no mass, friction or reading.
        """

        def grown(scale: float) -> float:
            return 1.0 + factor * (scale - 1.0)

        sensing = ForceSensing(
            gain={name: grown(gain) for name, gain in self.sensing.gain.items()},
            turn={name: _part(turn, factor) for name, turn in self.sensing.turn.items()},
            noise=factor * self.sensing.noise,
            delay_s=factor * self.sensing.delay_s,
        )
        larger = replace(
            self,
            offset=factor * self.offset,
            mass_scale=grown(self.mass_scale),
            finger_friction_scale=grown(self.finger_friction_scale),
            table_friction_scale=grown(self.table_friction_scale),
            handle_growth=factor * self.handle_growth,
            joint_friction=factor * self.joint_friction,
            sensing=sensing,
        )
        scales = (
            larger.mass_scale,
            larger.finger_friction_scale,
            larger.table_friction_scale,
            *sensing.gain.values(),
        )
        if not factor >= 0.0 or min(scales) <= 0.0:
            what = f"errors {factor:g} times as large leave no mass, friction or force reading"
            raise InputError(what, where="perturbation", mend="give a smaller factor, not below 0")
        return larger


def size_of_errors(seed: int, largest: float) -> float:
    """The factor of a trial's errors: uniform between 1 and ``largest``, by the trial's seed."""
    return float(np.random.default_rng([seed, _SIZE_STREAM]).uniform(1.0, largest))


def _part(turn: Array, factor: float) -> Array:
    """A rotation about the same axis by ``factor`` times the angle."""
    return (Rotation.from_matrix(turn) ** factor).as_matrix()


def _turn(rng: np.random.Generator, largest_deg: float) -> Array:
    axis = rng.normal(size=3)
    angle = np.radians(largest_deg) * rng.uniform()
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()


def _finite(robot: Robot) -> Array:
    return np.where(np.isfinite(robot.effort_max), robot.effort_max, 0.0)
