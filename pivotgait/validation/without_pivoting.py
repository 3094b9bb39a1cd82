"""What a hand does that cannot pivot the tool: a baseline for the removal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pivotgait.exceptions import InputError, PlanFileError
from pivotgait.forces import allocate
from pivotgait.frozen import Array
from pivotgait.models import HandleContact, Scene
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Setting, finger_track
from pivotgait.phases.relocation import resting_tool
from pivotgait.phases.tracking import JointMotion, with_torques
from pivotgait.plans import PIVOT, ContactTrack, GaitPlan, Phase

_CONE_SCALE = 50.0
"""Cones this much wider hold every force; which of them is the best does not depend on it."""
_SAME_PLACE_M = 1e-6


def without_pivoting(plan: GaitPlan, scene: Scene) -> GaitPlan:
    """The plan up to its first removal, in which the tool and the hand now stand still.

    The removed finger's normal force goes to zero as planned. The other forces balance gravity at
    every sample and are the least violating ones: they minimise the largest |f_t| / (mu f_n).
    Where that is above one, no forces within the cones exist, and the contacts will slip. The
    forces of the removal's start, among which such a choice was not made, fade with the ramp.
    The gait ends there, since what would follow starts from another orientation of the tool.

    Args:
        plan: with a robot and a removal.
        scene: of the plan.

    Raises:
        InputError: for a plan without a removal.
        PlanFileError: for a plan without a robot.
    """
    places = [k for k, phase in enumerate(plan.phases) if phase.kind == "removal"]
    if not places:
        raise InputError("has no removal", where="plan", mend="choose a gait with a removal")
    kept = plan.phases[: places[0]]
    return replace(plan, phases=(*kept, _still(plan.phases[places[0]], scene)))


def friction_share(phase: Phase) -> Array:
    """(N,) largest |f_t| / (mu f_n) of the contacts that carry force; above one none holds."""
    turn = phase.tool.rotation.as_matrix()
    shares = []
    for name, track in phase.contacts.items():
        normal = track.normal if name == PIVOT else np.einsum("nij,j->ni", turn, track.normal)
        along = np.sum(track.force * normal, axis=-1)
        across = np.linalg.norm(track.force - along[:, None] * normal, axis=1)
        loaded = along > 1e-9
        share = across / np.where(loaded, track.friction * along, 1.0)
        shares.append(np.where(loaded, share, 0.0))
    return np.asarray(np.max(shares, axis=0))


def _still(removal: Phase, scene: Scene) -> Phase:
    robot, motion = scene.robot, removal.robot
    if robot is None or motion is None:
        raise PlanFileError("has no motion of a robot", where=removal.name, mend="plan again")
    setting, count = Setting.of(scene), len(removal.time)
    tool = resting_tool(setting, removal.tool.rotation[0], count)
    fingers = [_contact(scene, t) for name, t in removal.contacts.items() if name != PIVOT]
    place = 1 + [each.finger for each in fingers].index(removal.finger)
    track = removal.contacts[removal.finger]
    turned = removal.tool.rotation.as_matrix() @ track.normal
    ramp = np.clip(np.sum(track.force * turned, axis=1), 0.0, None)
    problem = allocation_problem(setting, tool, fingers, ramp={removal.finger: ramp})
    wide = replace(problem, friction=_CONE_SCALE * problem.friction, objective="margin")
    force = np.array(allocate(wide).require().force)
    begun = np.stack([removal.contacts[name].force[0] for name in problem.names])
    # Their difference is an internal force: it moves nothing however it is scaled.
    force += (ramp / ramp[0])[:, None, None] * (begun - force[0])
    contacts = {PIVOT: setting.pivot_track(force[:, 0])}
    for k, each in enumerate(fingers, start=1):
        contacts[each.finger] = finger_track(each, force[:, k], changing=k == place)
    rest = np.zeros((count, robot.nv))
    joints = JointMotion(np.tile(motion.q[0], (count, 1)), rest, rest)
    return replace(
        removal,
        tool=tool,
        contacts=contacts,
        robot=with_torques(robot, joints, contacts, tool),
        record={"solver": "least violating forces, the tool at rest"},
    )


def _contact(scene: Scene, track: ContactTrack) -> HandleContact:
    """The scene's contact of a track.

    Raises:
        PlanFileError: if there is none.
    """
    for contact in scene.contacts.values():
        same = np.allclose(contact.point, track.point, atol=_SAME_PLACE_M)
        if contact.finger == track.name and same:
            return contact
    raise PlanFileError(f"contact of {track.name} is not the scene's", where="plan")
