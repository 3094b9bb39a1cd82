"""Key poses of the knife's lift and of the finger that comes after it, without any forces."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.frozen import Array
from pivotgait.models import LiftPhase, Robot, Scene, load_scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose

LIFTERS = ("thumb_spine", "index_edge")
THIRD = "middle_flat"
SINGULAR_VALUE_MIN = 5e-4


@cache
def scene() -> Scene:
    """The built-in knife."""
    return load_scene("knife")


def robot() -> Robot:
    """The scene's."""
    found = scene().robot
    assert found is not None
    return found


def world() -> CollisionWorld:
    """A new one: worlds own buffers."""
    return CollisionWorld(robot(), scene().tool, scene().table.height, scene().clearance)


def keys(shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[KeyPose, ...]:
    """Start, middle and end of the lift, then the third finger at its contact.

    Args:
        shift: of the tool and of all its contacts [m].
    """
    knife, lift = scene(), scene().gaits["default"][0]
    assert isinstance(lift, LiftPhase)
    ends = Rotation.concatenate([knife.rest_rotation, knife.lift_rotation(lift.to)])
    turns = Slerp([0.0, 1.0], ends)([0.0, 0.5, 1.0, 1.0])
    touching = [LIFTERS] * 3 + [(*LIFTERS, THIRD)]
    return tuple(
        KeyPose(
            f"key {k}",
            turn.as_matrix(),
            knife.centre_of_mass(turn) + np.array(shift),
            {knife.contacts[each].finger: knife.contacts[each] for each in names},
        )
        for k, (turn, names) in enumerate(zip(turns, touching, strict=True))
    )


def anywhere(rng: np.random.Generator, count: int) -> Array:
    """(count, nv) configurations within the joint limits and within a turn of home."""
    each = robot()
    low, high = np.maximum(each.lower, each.home - np.pi), np.minimum(each.upper, each.home + np.pi)
    return rng.uniform(low, high, (count, each.nv))
