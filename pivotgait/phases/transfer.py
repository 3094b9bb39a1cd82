"""Transfer: the fingers take the tool off the table (the end of Xue et al., Fig. 7).

First the pivot's force fades to zero while the tool rests, then the tool rises straight up without
turning, then it hangs still. Two point contacts bear no moment about the line through them; that
of the weight vanishes if the line is in a vertical plane through the centre of mass, and what is
left of it soft fingertips bear by torsion (:mod:`pivotgait.forces.soft_finger`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pivotgait.dynamics import required_wrench
from pivotgait.exceptions import InfeasibleError
from pivotgait.forces.soft_finger import SoftFingerProblem, allocate_soft
from pivotgait.frozen import Array
from pivotgait.models import HandleContact
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.phases.relocation import resting_tool
from pivotgait.phases.timing import quintic
from pivotgait.plans import PIVOT, Phase, ToolMotion

UNLOADING = 0.3
"""Share of the duration in which the pivot's force fades."""
RISING = 0.5
"""Share of the duration in which the tool rises; the rest of it hangs."""


@dataclass(frozen=True)
class TransferOptions:
    """How to lift the tool off.

    Attributes:
        duration_s: [s].
        steps: number of intervals K.
        rise_m: way of the tool straight up [m].
    """

    duration_s: float
    steps: int
    rise_m: float


def plan_transfer(
    setting: Setting, grasp: Grasp, options: TransferOptions, *, name: str
) -> tuple[Phase, Grasp]:
    """Plan the lifting off.

    Forces and moments minimise (|f_t|^2 + (mu m / e)^2) / f_n, whatever objective the scene names.

    Args:
        setting: tool and table.
        grasp: the tool at rest on its pivot, held with known forces.
        options: timing and height.
        name: of the phase.

    Returns:
        The phase and the grasp it ends in, whose tool is off the table.

    Raises:
        InfeasibleError: the fingers cannot carry the tool alone, or not without exceeding the
            rate of force.
    """
    time = np.linspace(0.0, options.duration_s, options.steps + 1)
    motion = _motion(setting, grasp, options, time)
    fingers = list(grasp.fingers.values())
    fading = np.clip(1.0 - time / (UNLOADING * options.duration_s), 0.0, None)
    pivot = fading[:, None] * grasp.forces[PIVOT]
    problem = soft_finger_problem(setting, motion, fingers, pivot, grasp, options)
    try:
        found = allocate_soft(problem)
    except InfeasibleError as error:
        what = f"{error.what}{_weight_about_line(setting, motion, fingers)}"
        raise InfeasibleError(what, where=name, mend=error.mend) from error
    contacts = {PIVOT: replace(setting.pivot_track(pivot), normal_min=0.0)}
    for place, each in enumerate(fingers):
        moment = found.moment[:, place] if each.torsion > 0.0 else None
        track = finger_track(each, found.force[:, place])
        contacts[each.finger] = replace(track, moment=moment)
    record = {"solver": "clarabel", "iterations": found.iterations}
    phase = Phase(name, "transfer", "", time, motion, contacts, record=record)
    return phase, Grasp.after(motion, grasp.fingers, contacts)


def _motion(setting: Setting, grasp: Grasp, options: TransferOptions, time: Array) -> ToolMotion:
    """Rest, rise by a quintic profile, rest."""
    start, length = UNLOADING * options.duration_s, RISING * options.duration_s
    inside = np.clip(time - start, 0.0, length)
    up = options.rise_m * np.array([0.0, 0.0, 1.0])
    rest = resting_tool(setting, grasp.rotation, len(time))
    way, speed, surge = (share[:, None] * up for share in quintic(inside, length))
    return replace(
        rest,
        position=rest.position + way,
        linear_velocity=speed,
        linear_acceleration=surge,
    )


def soft_finger_problem(
    setting: Setting,
    motion: ToolMotion,
    fingers: list[HandleContact],
    pivot: Array,
    grasp: Grasp,
    options: TransferOptions,
) -> SoftFingerProblem:
    """What the fingers must apply along a motion while the table applies ``pivot`` (N, 3) [N]."""
    scene, turn = setting.scene, motion.rotation.as_matrix()
    arm = turn @ setting.body.pivot_in_tool
    by_pivot = np.concatenate((pivot, np.cross(arm, pivot)), axis=1)
    usable = 1.0 - scene.allocation.friction_reserve
    return SoftFingerProblem(
        names=tuple(each.finger for each in fingers),
        lever=np.stack([turn @ each.point for each in fingers], axis=1),
        normals=np.stack([turn @ each.normal for each in fingers], axis=1),
        friction=setting.usable_friction(fingers)[1:],
        torsion=usable * np.array([each.torsion for each in fingers]),
        normal_min=np.array([each.normal_min for each in fingers]),
        normal_max=np.array([each.normal_max for each in fingers]),
        wrench=required_wrench(setting.body, motion) - by_pivot,
        start=np.stack([grasp.forces[each.finger] for each in fingers]),
        force_rate_max=scene.allocation.force_rate_max_N_s,
        step_s=options.duration_s / options.steps,
    )


def _weight_about_line(setting: Setting, motion: ToolMotion, fingers: list[HandleContact]) -> str:
    """What two fingers cannot bear but by torsion, as a clause for a message."""
    if len(fingers) != 2:
        return ""
    one, other = (motion.rotation[0].as_matrix() @ each.point for each in fingers)
    line = (other - one) / np.linalg.norm(other - one)
    weight = setting.body.mass * setting.body.gravity
    moment = abs(float(np.cross(-one, weight) @ line))
    return f"; the weight turns it about the line through them with {1e3 * moment:.1f} mN m"
