"""Addition: load a finger that has reached its contact while the tool rests (Section IV-B)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pivotgait.forces import LinearRows, allocate
from pivotgait.models import HandleContact
from pivotgait.phases.allocation import allocate_smoothly, allocation_problem
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.phases.relocation import resting_tool
from pivotgait.plans import PIVOT, Phase


@dataclass(frozen=True)
class AdditionOptions:
    """How to add a finger: duration [s] and number of intervals L."""

    duration_s: float
    steps: int


def plan_addition(
    setting: Setting,
    grasp: Grasp,
    contact: HandleContact,
    options: AdditionOptions,
    *,
    name: str,
    rows: LinearRows | None = None,
) -> tuple[Phase, Grasp]:
    """Plan the loading of one more finger.

    The wanted forces f_d solve eq. (4) once with the new contact; then eq. (4) is solved along
    the ramp f_3n = (l / L) f_3,nd of eq. (8), from the forces that hold the tool now to f_d.

    Args:
        setting: tool and table.
        grasp: the tool at rest, held with known forces.
        contact: the new contact.
        options: timing.
        name: of the phase.
        rows: joint torque limits at the L + 1 samples, or None.

    Returns:
        The phase and the grasp it ends in.

    Raises:
        InfeasibleError: the fingers cannot hold the tool with the new contact, or not without
            exceeding the rate of force.
    """
    steps, finger = options.steps, contact.finger
    time = np.linspace(0.0, options.duration_s, steps + 1)
    motion = resting_tool(setting, grasp.rotation, steps + 1)
    fingers = [*grasp.fingers.values(), contact]

    rest = resting_tool(setting, grasp.rotation, 1)
    wanted = (
        allocate(allocation_problem(setting, rest, fingers, rows=_last(rows))).require().force[0]
    )
    normal_wanted = float(wanted[-1] @ (grasp.rotation.as_matrix() @ contact.normal))
    ramp = {finger: np.arange(steps + 1) / steps * normal_wanted}
    held = np.stack([grasp.forces[each] for each in (PIVOT, *grasp.fingers)])
    allocation = allocate_smoothly(
        allocation_problem(setting, motion, fingers, ramp=ramp, rows=rows),
        step_s=options.duration_s / steps,
        rate_max=setting.scene.allocation.force_rate_max_N_s,
        start=np.vstack((held, np.zeros(3))),
        end=wanted,
    )
    contacts = {PIVOT: setting.pivot_track(allocation.force[:, 0])}
    for place, each in enumerate(fingers, start=1):
        force = allocation.force[:, place]
        contacts[each.finger] = finger_track(each, force, changing=each is contact)
    record = {"solver": allocation.solver}
    phase = Phase(name, "addition", finger, time, motion, contacts, record=record)
    return phase, Grasp.after(motion, {**grasp.fingers, finger: contact}, contacts)


def _last(rows: LinearRows | None) -> LinearRows | None:
    return rows and LinearRows(rows.matrix[-1:], rows.lower[-1:], rows.upper[-1:])
