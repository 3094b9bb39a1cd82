"""Which grasps are near the goal for the hand: seen from the palm as it holds the goal.

While one finger after the other moves, the palm stays much where it is. Contacts that fingers
reach from where the palm must end up are therefore the ones to begin with.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.frozen import Array
from pivotgait.gait_search.candidates import Candidate
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.hand_reach import HandReach, palm_in_tool
from pivotgait.models import Robot, Scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_search import PostureOptions, PostureSearch

PER_METRE = 80.0
"""Rank added for each metre by which contacts are missed [1/m]."""
NEAR_M = 0.01
"""Contacts missed by less are as good as reached [m]: the palm moves a little."""
STARTS = 60
"""Random starts of the goal's postures."""


class Guidance:
    """Postures of the hand at the goal, and how far contacts are from its fingers there.

    Args:
        scene: with a robot.
        robot: of the scene.
        goal: without named contacts it guides nowhere.
        attitude: of the tool at which the goal is tried, world <- tool.
        rng: of the starts.
        postures: most postures.

    Attributes:
        q: (W, nv) postures at the goal; none if it names no contacts or none was found.
    """

    def __init__(
        self,
        scene: Scene,
        robot: Robot,
        goal: Goal,
        attitude: Rotation,
        rng: np.random.Generator,
        postures: int = 3,
    ) -> None:
        self._reach = HandReach(robot, scene.clearance)
        self._missed: dict[str, Array] = {}
        found: list[Array] = []
        self._palms = []
        if goal.contacts:
            contacts = {each.finger: each.contact for each in goal.contacts.values()}
            turn, place = attitude.as_matrix(), scene.centre_of_mass(attitude)
            key = KeyPose("goal", turn, place, contacts)
            world = CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)
            options = PostureOptions(starts=STARTS, time_limit_s=np.inf)
            search = PostureSearch(robot, world, [key], rng, options)
            for each in islice(search.candidates(), postures):
                found.append(each.q[0])
                self._palms.append(palm_in_tool(robot, each.q[0], turn, place))
        self.q = np.array(found).reshape(-1, robot.nv)

    def rank(self, held: Mapping[str, Candidate]) -> float:
        """What a grasp waits longer for being far from the goal's hand; 0 without guidance."""
        if not self._palms or not held:
            return 0.0
        missed = np.sum([self._miss(each) for each in held.values()], axis=0)
        return PER_METRE * float(np.min(missed))

    def _miss(self, candidate: Candidate) -> Array:
        """(W,) from each of the goal's palms, beyond what counts as near [m]."""
        if candidate.name not in self._missed:
            contact = candidate.contact
            found = np.array([self._reach.miss(contact, palm) for palm in self._palms])
            self._missed[candidate.name] = np.maximum(found - NEAR_M, 0.0)
        return self._missed[candidate.name]
