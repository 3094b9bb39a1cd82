"""Force allocation against its peers, on random grasps of a kitchen knife."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pivotgait.forces import AllocationProblem
from pivotgait.forces.problem import Objective

Array = NDArray[np.float64]
NAMES = ("pivot", "thumb", "index", "middle", "ring")
KNIFE_MASS = 0.225  # [kg]
TIP_TO_COM = 0.22  # [m]
HANDLE_HALF_WIDTH, HANDLE_HALF_HEIGHT = 0.010, 0.0145  # [m] stadium cross-section
AROUND = np.radians((90.0, -90.0, 180.0, 0.0))
"""Places of thumb, index, middle, ring around the handle, from its top (z) towards y."""


def random_problem(
    rng: np.random.Generator,
    samples: int,
    contacts: int,
    objective: Objective = "alignment",
    *,
    spread: float = 1.0,
) -> AllocationProblem:
    """Random samples of a knife that pivots on the table, held by ``contacts - 1`` fingers.

    The knife of 0.225 kg is lifted by about 25 degrees, the fingers hold its handle about
    0.27 m from the pivot; friction 0.4 at the table, 0.8 at the fingers, finger forces in
    [0.3, 4] N. With two contacts, which cannot apply every wrench, the wrench is that of random
    forces. Most samples are feasible; a larger ``spread`` of the places makes fewer so.

    Args:
        rng: source of randomness.
        samples: number of samples T.
        contacts: 2 to 5, the pivot among them.
        objective: of the problem.
        spread: scales the random part of contact places and accelerations.
    """
    fingers = contacts - 1
    shape = (samples, fingers)
    angle = AROUND[:fingers] + spread * rng.normal(0.0, 0.15, shape)
    along = -0.05 + spread * rng.uniform(-0.03, 0.03, shape)
    normals = np.zeros((samples, contacts, 3))
    lever = np.zeros((samples, contacts, 3))
    normals[:, 1:, 1], normals[:, 1:, 2] = -np.sin(angle), -np.cos(angle)
    straight = HANDLE_HALF_HEIGHT - HANDLE_HALF_WIDTH
    lever[:, 1:] = -HANDLE_HALF_WIDTH * normals[:, 1:]
    lever[:, 1:, 2] += straight * np.cos(angle)
    lever[:, 1:, 0] = along
    lever[:, 0] = (TIP_TO_COM, 0.0, -0.02)

    pitch = np.radians(25.0) + spread * rng.normal(0.0, 0.1, samples)
    roll = spread * rng.normal(0.0, 0.1, samples)
    tilt = _rotation_y(pitch) @ _rotation_x(roll)
    normals, lever = normals @ np.swapaxes(tilt, 1, 2), lever @ np.swapaxes(tilt, 1, 2)
    normals[:, 0] = (0.0, 0.0, 1.0)

    friction = np.full(contacts, 0.8)
    friction[0] = 0.4
    if fingers == 1:
        along_normal = rng.uniform(0.5, 3.0, (samples, contacts, 1))
        force = along_normal * (normals + 0.2 * spread * rng.normal(size=normals.shape))
        moment = np.cross(lever, force).sum(axis=1)
        wrench = np.concatenate((force.sum(axis=1), moment), axis=1)
    else:
        wrench = np.zeros((samples, 6))
        wrench[:, :3] = KNIFE_MASS * spread * rng.normal(0.0, 0.3, (samples, 3))
        wrench[:, 2] += KNIFE_MASS * 9.81
        wrench[:, 3:] = spread * rng.normal(0.0, 0.004, (samples, 3))
    normal_min = np.full((samples, contacts), 0.3)
    normal_min[:, 0] = 0.05
    normal_max = np.full((samples, contacts), 4.0)
    normal_max[:, 0] = 10.0
    return AllocationProblem(
        names=NAMES[:contacts],
        lever=lever,
        normals=normals,
        friction=friction,
        normal_min=normal_min,
        normal_max=normal_max,
        wrench=wrench,
        objective=objective,
    )


def _rotation_y(angle: Array) -> Array:
    out = np.zeros((len(angle), 3, 3))
    out[:, 0, 0] = out[:, 2, 2] = np.cos(angle)
    out[:, 0, 2], out[:, 2, 0], out[:, 1, 1] = np.sin(angle), -np.sin(angle), 1.0
    return out


def _rotation_x(angle: Array) -> Array:
    out = np.zeros((len(angle), 3, 3))
    out[:, 1, 1] = out[:, 2, 2] = np.cos(angle)
    out[:, 1, 2], out[:, 2, 1], out[:, 0, 0] = -np.sin(angle), np.sin(angle), 1.0
    return out
