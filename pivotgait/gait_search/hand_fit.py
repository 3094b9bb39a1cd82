"""What every search for postures of a branch shares: the hand, its surroundings, random starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pivotgait.models import Robot, Scene
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_search import PostureOptions, PostureSearch


class HandFit:
    """Fits of the hand to key poses.

    Args:
        scene: of the hand.
        robot: of the scene.
        options: of the random starts.
        seed: of the starts; the same seed gives the same postures.
    """

    def __init__(self, scene: Scene, robot: Robot, options: PostureOptions, seed: int) -> None:
        self.robot, self.rounds = robot, options.rounds
        self._options, self._seed = options, seed
        self._world = CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)

    def chain(self, keys: Sequence[KeyPose]) -> PostureChain:
        """The key poses together."""
        return PostureChain(self.robot, self._world, keys, self._options.singular_value_min)

    def anywhere(self, keys: Sequence[KeyPose], number: int) -> Iterator[Postures | Refused]:
        """Postures from random starts, then why the others failed most often.

        Args:
            keys: to be fitted.
            number: of the search, so that each has starts of its own.
        """
        rng = np.random.default_rng((self._seed, number))
        search = PostureSearch(self.robot, self._world, keys, rng, self._options)
        yield from search.candidates()
        if search.record.failures:
            kind, _, about = search.record.failures.most_common(1)[0][0].partition(": ")
            yield Refused(kind, about)
