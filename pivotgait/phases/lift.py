"""Lift: pivot the tool about its tip from rest to a target orientation (Section III)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import pivot_motion
from pivotgait.forces import LinearRows
from pivotgait.frozen import Array
from pivotgait.phases.allocation import allocate_smoothly, allocation_problem
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.phases.timing import PROFILES, Profile
from pivotgait.plans import PIVOT, Phase, ToolMotion


@dataclass(frozen=True)
class LiftOptions:
    """How to lift.

    Attributes:
        duration_s: [s].
        steps: number of intervals K.
        profile: timing law of the slerp; ``quintic`` keeps forces continuous.
    """

    duration_s: float
    steps: int
    profile: Profile = "quintic"


def lift_motion(
    setting: Setting, start: Rotation, target: Rotation, options: LiftOptions
) -> tuple[Array, ToolMotion]:
    """Times (K + 1,) from the start [s] and the tool's motion there, from rest to rest."""
    time = np.linspace(0.0, options.duration_s, options.steps + 1)
    fraction, rate, acceleration = PROFILES[options.profile](time, options.duration_s)
    turn = (target * start.inv()).as_rotvec()
    motion = pivot_motion(
        setting.body,
        Rotation.from_rotvec(fraction[:, None] * turn) * start,
        rate[:, None] * turn,
        acceleration[:, None] * turn,
    )
    return time, motion


def plan_lift(
    setting: Setting,
    grasp: Grasp,
    target: Rotation,
    options: LiftOptions,
    *,
    name: str,
    rows: LinearRows | None = None,
) -> tuple[Phase, Grasp]:
    """Plan the lift and the forces of eqs (4)-(6) along it.

    The orientation is the slerp R(s) = Exp(s a) R_0 with the constant axis-angle a from start
    to target; its velocity s' a and acceleration s'' a are the analytic derivatives.

    Args:
        setting: tool and table.
        grasp: the tool at rest on the table and the fingers that touch it.
        target: orientation at the end, world <- tool.
        options: timing.
        name: of the phase.
        rows: joint torque limits at the K + 1 samples, or None.

    Returns:
        The phase and the grasp it ends in.

    Raises:
        InfeasibleError: at some sample no forces satisfy dynamics, cones and bounds.
    """
    time, motion = lift_motion(setting, grasp.rotation, target, options)
    fingers = list(grasp.fingers.values())
    smooth = options.profile == "quintic"
    allocation = allocate_smoothly(
        allocation_problem(setting, motion, fingers, rows=rows),
        step_s=options.duration_s / options.steps,
        # a trapezoidal profile jumps in acceleration, and the forces must jump with it
        rate_max=setting.scene.allocation.force_rate_max_N_s if smooth else None,
    )
    contacts = {PIVOT: setting.pivot_track(allocation.force[:, 0])}
    for place, finger in enumerate(fingers, start=1):
        contacts[finger.finger] = finger_track(finger, allocation.force[:, place])
    phase = Phase(name, "lift", "", time, motion, contacts, record={"solver": allocation.solver})
    return phase, Grasp.after(motion, grasp.fingers, contacts)
