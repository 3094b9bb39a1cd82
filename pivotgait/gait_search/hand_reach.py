"""Where a hand's fingertips can be: the cheapest tests of whether it reaches contacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pivotgait.frozen import Array, FrozenArrays
from pivotgait.models import HandleContact, Robot

SAMPLES = 3000
SLACK = 1.05
"""Random bends of the fingers miss the farthest reach by a few percent."""
NEIGHBOURS = 48
"""Bends looked at about a place."""
PAD_SLACK = np.radians(20.0)
"""The hand may turn a little, too."""
FAR_M = 0.2
"""Distance of a place that no bend comes near with its pad."""


@dataclass(frozen=True, eq=False)
class TipCloud(FrozenArrays):
    """A fingertip in random bends of its finger, seen from the palm's frame.

    Attributes:
        centre: (S, 3) of the tip [m].
        pad: (S, 3) unit direction from the tip's centre to the middle of its pad.
        cone: largest angle between ``pad`` and the direction to a contact [rad].
    """

    centre: Array
    pad: Array
    cone: float


class HandReach:
    """How far apart fingertips can be, and how far a place is from what a finger reaches.

    Only the fingers' joints are bent: the arm can bring the palm anywhere.

    Args:
        robot: the arm-hand.
        clearance: smallest distance of two tips' surfaces [m].
    """

    def __init__(self, robot: Robot, clearance: float) -> None:
        self._robot = robot
        self._clouds = _clouds(robot)
        self._trees = {name: KDTree(cloud.centre) for name, cloud in self._clouds.items()}
        self._farthest: dict[frozenset[str], float] = {}
        self._nearest: dict[frozenset[str], float] = {}
        for one, other in combinations(robot.fingers, 2):
            pair = frozenset((one, other))
            apart = self._clouds[one].centre - self._clouds[other].centre
            self._farthest[pair] = SLACK * float(np.linalg.norm(apart, axis=1).max())
            radii = robot.fingers[one].tip_radius + robot.fingers[other].tip_radius
            self._nearest[pair] = radii + clearance

    def admits(self, one: str, other: str, distance: Array) -> NDArray[np.bool_]:
        """(...,) whether two fingers' tips can be so far apart, and need not be nearer.

        Args:
            one: a finger.
            other: another finger.
            distance: (...,) of their tips' centres [m].
        """
        pair = frozenset((one, other))
        near: NDArray[np.bool_] = np.asarray(distance) <= self._farthest[pair]
        return near & (np.asarray(distance) >= self._nearest[pair])

    def miss(self, contact: HandleContact, palm: pin.SE3) -> float:
        """How far a contact is from the places that its finger reaches with its pad [m].

        Args:
            contact: on the tool.
            palm: pose of the palm's frame in the tool frame.
        """
        finger, cloud = self._robot.fingers[contact.finger], self._clouds[contact.finger]
        centre = palm.actInv(contact.point - finger.tip_radius * contact.normal)
        inward = palm.rotation.T @ contact.normal
        found = self._trees[contact.finger].query(centre, k=NEIGHBOURS)
        distance, place = (np.asarray(each) for each in found)
        fits = cloud.pad[place] @ inward >= np.cos(min(cloud.cone + PAD_SLACK, np.pi))
        return float(min(np.min(distance[fits], initial=FAR_M), FAR_M))


def palm_in_tool(robot: Robot, q: Array, rotation: Array, position: Array) -> pin.SE3:
    """Pose of the palm's frame in the tool frame.

    Args:
        robot: the arm-hand.
        q: (nv,) joint positions.
        rotation: (3, 3) of the tool, world <- tool.
        position: (3,) of its centre of mass, world [m].
    """
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, np.array(q))
    tool = pin.SE3(np.array(rotation), np.array(position))
    return tool.actInv(data.oMf[robot.palm_frame_id])


def _clouds(robot: Robot) -> Mapping[str, TipCloud]:
    rng = np.random.default_rng(0)  # a fixed sample: the answer belongs to the robot
    data = robot.model.createData()
    bent = [column for finger in robot.fingers.values() for column in finger.columns]
    centres = {name: np.zeros((SAMPLES, 3)) for name in robot.fingers}
    pads = {name: np.zeros((SAMPLES, 3)) for name in robot.fingers}
    for k in range(SAMPLES):
        q = np.array(robot.home)
        q[bent] = rng.uniform(robot.lower[bent], robot.upper[bent])
        for i, j in robot.couplings:
            q[i] = min(q[i], q[j])
        pin.framesForwardKinematics(robot.model, data, q)
        palm = data.oMf[robot.palm_frame_id]
        for name, finger in robot.fingers.items():
            tip = palm.actInv(data.oMf[finger.tip_frame_id])
            centres[name][k], pads[name][k] = tip.translation, tip.rotation @ finger.pad
    return {
        name: TipCloud(centres[name], pads[name], robot.fingers[name].pad_cone)
        for name in robot.fingers
    }
