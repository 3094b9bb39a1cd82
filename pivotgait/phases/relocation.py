"""Relocation: a free finger goes to a contact while the others hold the tool (Section V)."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import pivot_motion
from pivotgait.frozen import Array
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.plans import PIVOT, Phase, ToolMotion


def resting_tool(setting: Setting, rotation: Rotation, samples: int) -> ToolMotion:
    """The tool at rest on its pivot, the same at every sample."""
    still = np.zeros((samples, 3))
    held = Rotation.from_quat(np.tile(rotation.as_quat(), (samples, 1)))
    return pivot_motion(setting.body, held, still, still)


def relocation_phase(
    setting: Setting, grasp: Grasp, finger: str, time: Array, *, name: str
) -> Phase:
    """The phase as the tool feels it: at rest, held by unchanging forces.

    Args:
        setting: tool and table.
        grasp: the tool at rest, held with known forces.
        finger: that moves; not among those that hold.
        time: (N,) from the phase's start [s].
        name: of the phase.
    """
    samples = len(time)
    constant = {each: np.tile(grasp.forces[each], (samples, 1)) for each in (PIVOT, *grasp.fingers)}
    contacts = {PIVOT: setting.pivot_track(constant[PIVOT])}
    for each, contact in grasp.fingers.items():
        contacts[each] = finger_track(contact, constant[each])
    motion = resting_tool(setting, grasp.rotation, samples)
    return Phase(name, "relocation", finger, time, motion, contacts)
