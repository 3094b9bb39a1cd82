"""How far a finger goes that closes along its planned normal until it feels the tool."""

from __future__ import annotations

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.models.coal_shapes import ball_distance
from pivotgait.plans import GaitPlan
from pivotgait.validation.real_tool import RealTool

_REACH_M = 0.01
_TOLERANCE_M = 1e-6
_STEPS = 200


def closing_distances(plan: GaitPlan, robot: Robot, real: RealTool, gap: float) -> dict[str, float]:
    """Where fingers stop that close on the tool as it really lies, as a guarded move does.

    A ball marches along the normal by its distance from the tool, which never oversteps.

    Args:
        plan: whose first phase's contacts the fingers aim at.
        robot: of the plan.
        real: the tool and where it lies.
        gap: left between fingertip and tool [m].

    Returns:
        By finger, the distance [m] from the planned place along the outward normal; negative
        behind it. A finger that meets nothing within 10 mm stops there.
    """
    first = plan.phases[0]
    turn = first.tool.rotation[0].as_matrix()
    found = {}
    for name, track in first.contacts.items():
        if track.is_pivot or name == first.finger:
            continue
        radius = robot.fingers[name].tip_radius
        inward = turn @ track.normal
        centre = first.tool.position[0] + turn @ track.point - radius * inward
        found[name] = _stop(real, centre, inward, radius + gap)
    return found


def _stop(real: RealTool, centre: Array, inward: Array, radius: float) -> float:
    away = _REACH_M
    for _ in range(_STEPS):
        place = real.rotation.T @ (centre - away * inward - real.position)
        distance = min(ball_distance(shape, place, radius)[0] for shape in real.tool.shapes)
        if distance < _TOLERANCE_M or away <= -_REACH_M:
            break
        away -= distance
    return max(away, -_REACH_M)
