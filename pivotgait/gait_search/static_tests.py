"""Can these fingers hold the tool at rest? Many grasps judged in one batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, Scene


def grasp_depths(
    scene: Scene,
    grasps: Sequence[Sequence[HandleContact]],
    rotation: Rotation,
    *,
    exact: bool = True,
) -> Array:
    """(N,) how far inside all limits the forces of each grasp can be [N]; negative: nowhere.

    Friction is what plans may use of it, the tool rests on its pivot.

    Args:
        scene: tool, table, limits.
        grasps: N of the same fingers in the same order.
        rotation: of the tool, world <- tool.
        exact: converge the depths; otherwise only their signs count.
    """
    if not grasps:
        return np.zeros(0)
    table = scene.table
    usable = 1.0 - scene.allocation.friction_reserve

    def limits(of_table: float, name: str) -> Array:
        fingers = np.array([[getattr(each, name) for each in grasp] for grasp in grasps])
        return np.column_stack((np.full(len(grasps), of_table), fingers))

    verdicts = static_verdicts(
        Grasps.resting(
            [each.finger for each in grasps[0]],
            rotation.as_matrix(),
            scene.tool.pivot_in_tool,
            np.array([[each.point for each in grasp] for grasp in grasps]),
            np.array([[each.normal for each in grasp] for grasp in grasps]),
            scene.tool.mass * scene.gravity,
            friction=usable * limits(table.friction, "friction"),
            normal_min=limits(table.normal_min, "normal_min"),
            normal_max=limits(table.normal_max, "normal_max"),
        ),
        exact=exact,
    )
    # a depth that is not converged may have rounded to the wrong side of 0
    inside, outside = np.maximum(verdicts.depth, 0.0), np.minimum(verdicts.depth, -1e-12)
    return np.asarray(np.where(verdicts.feasible, inside, outside))


def can_carry(scene: Scene, contacts: Sequence[HandleContact], rotation: Rotation) -> bool:
    """Whether fingers might carry the tool at rest without the table; a necessary condition.

    Two fingers bear a moment about the line through them by torsion alone, that of the weight
    included. Three and more are left to the planner of the phase.

    Args:
        scene: tool and the share of friction that plans may use.
        contacts: of the fingers.
        rotation: of the tool, world <- tool.
    """
    if len(contacts) != 2:
        return True
    turn = rotation.as_matrix()
    one, other = (turn @ each.point for each in contacts)
    line = (other - one) / np.linalg.norm(other - one)
    weight = scene.tool.mass * scene.gravity
    moment = abs(float(np.cross(-one, weight) @ line))
    usable = 1.0 - scene.allocation.friction_reserve
    borne = sum(
        usable * each.torsion * each.normal_max * abs(float(turn @ each.normal @ line))
        for each in contacts
    )
    return moment <= borne
