"""Where the fingertips are and how they move, from joint positions, speeds and accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pivotgait.certification.rigid_robot import RigidRobot
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.plans import ContactTrack, Phase, RobotMotion


@dataclass(frozen=True, eq=False)
class TipMotion(FrozenArrays):
    """Motion of a fingertip at N samples, in the world frame.

    Attributes:
        position: (N, 3) of the tip's centre [m].
        rotation: (N, 3, 3) world <- tip.
        velocity: (N, 3) of the centre [m/s].
        angular_velocity: (N, 3) [rad/s].
        acceleration: (N, 3) of the centre [m/s^2].
        angular_acceleration: (N, 3) [rad/s^2].
    """

    position: Array
    rotation: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array


def tip_motions(rigid: RigidRobot, motion: RobotMotion) -> dict[str, TipMotion]:
    """Motion of every finger's tip along a phase, by finger."""
    samples: dict[str, list[tuple[Array, ...]]] = {name: [] for name in rigid.tip_frames}
    model, data = rigid.model, rigid.model.createData()
    for q, v, a in zip(motion.q, motion.v, motion.a, strict=True):
        pin.forwardKinematics(model, data, q, v, a)
        for name, frame in rigid.tip_frames.items():
            place = pin.updateFramePlacement(model, data, frame)
            axes = pin.LOCAL_WORLD_ALIGNED
            speed = pin.getFrameVelocity(model, data, frame, axes)
            surge = pin.getFrameClassicalAcceleration(model, data, frame, axes)
            parts = (place.translation, place.rotation, speed.linear, speed.angular)
            samples[name].append((*map(np.array, parts), *map(np.array, np.split(surge.vector, 2))))
    return {
        name: TipMotion(*map(np.array, zip(*found, strict=True))) for name, found in samples.items()
    }


def holding(phase: Phase) -> tuple[str, ...]:
    """Fingers whose tips stay at their contacts during the whole phase.

    A finger that comes or goes by force does so in place: it has its contact from an addition's
    first sample to a removal's last.
    """
    moving = phase.finger if phase.kind == "relocation" else ""
    return tuple(
        name
        for name, contact in sorted(phase.contacts.items())
        if not contact.is_pivot and name != moving
    )


def held_point(contact: ContactTrack, radius: float) -> Array:
    """(3,) where the tip's centre must be in the tool frame [m]."""
    return np.asarray(contact.point - radius * contact.normal)
