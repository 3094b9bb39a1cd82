"""The order of fingers that the forces of a goal's contacts allow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pivotgait.feasibility.turns import smallest_tilt
from pivotgait.gait_search.candidates import Candidate, fingers_of
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.moves import Moves
from pivotgait.gait_search.order import Order
from pivotgait.gait_search.static_tests import grasp_depths


def order_by_forces(moves: Moves, goal: Goal) -> Order:
    """The orders of fingers towards a goal that names its contacts.

    Which of them hold the tool by themselves is looked for over all tilts of the tool: turning
    about the vertical changes no force at rest.

    Args:
        moves: of the search; its lifts are the ways to begin.
        goal: wanted.
    """
    scene = moves.scene
    attitude = scene.lift_rotation(moves.targets()[0])

    def holds(grasp: Sequence[Candidate]) -> bool:
        contacts = [each.contact for each in grasp]
        if grasp_depths(scene, [contacts], attitude)[0] >= 0.0:
            return True
        return smallest_tilt(scene, contacts, attitude, turn_max_rad=np.pi).feasible

    return Order(
        fingers_of(scene),
        goal.contacts,
        [move.contacts for move in moves.lifts],
        holds,
        moves.prices,
        carried=goal.lifted_off,
    )
