"""Relocation: a free finger goes to a contact while the others hold the tool (Section V)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from pivotgait.dynamics import pivot_motion
from pivotgait.frozen import Array
from pivotgait.kinematics import Hold
from pivotgait.models import HandleContact, Scene
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.problem import RelocationOptions, RelocationProblem
from pivotgait.planning.tool_path import PivotingTool
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


def relocation_problem(
    scene: Scene,
    world: CollisionWorld,
    rotation: Rotation,
    holds: Sequence[Hold],
    contact: HandleContact,
    *,
    start: Array,
    goal: Array,
    lands: bool = True,
    left: HandleContact | None = None,
    options: RelocationOptions | None = None,
) -> RelocationProblem:
    """The problem of bringing a finger to a contact while the tool rests on its pivot.

    Args:
        scene: whose tool rests.
        world: of the scene's robot, without exemptions.
        rotation: of the tool, world <- tool.
        holds: of the fingers that hold it.
        contact: to which its finger goes.
        start: (nv,) joint positions, at the holds.
        goal: (nv,) joint positions, at the holds and the contact.
        lands: whether the finger touches the contact at the end; else it ends in the air.
        left: the contact the finger still is at; None if it starts in the air.
        options: of the search.

    Raises:
        InputError: for positions of a wrong shape or not finite, or a finger that holds.
    """
    return RelocationProblem(
        robot=world.robot,
        world=world,
        holds=tuple(holds),
        finger=contact.finger,
        start=start,
        goal=goal,
        tool=PivotingTool.resting(rotation.as_matrix(), scene.centre_of_mass(rotation)),
        start_normal=None if left is None else left.normal,
        goal_normal=contact.normal if lands else None,
        options=options or RelocationOptions(),
    )
