"""The rest of a gait, planned anew from where tool, fingers and joints are measured to be.

Between two gaits every finger rests on the tool. What has slipped, rolled or crept until then is no
error any more once it is planned from: the tool stands where it stands, fingers hold where they
hold. Motion and forces of the remaining phases are planned as for any gait; the hand goes on next
to how it was to go, since its postures were chosen for the whole gait.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.forces import allocate
from pivotgait.frozen import Array, FrozenArrays
from pivotgait.gaits.hand import HandOptions, HandPlanner
from pivotgait.gaits.planner import weakest_joint
from pivotgait.gaits.steps import plan_steps
from pivotgait.models import (
    AdditionPhase,
    HandleContact,
    LiftPhase,
    PhaseConfig,
    RemovalPhase,
    Robot,
    Scene,
)
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.relocation import resting_tool
from pivotgait.plans import PIVOT, GaitPlan

_CLEARANCE_SHARE = 0.2
"""Of the scene's clearance: the rest of it is what a measured state may have lost."""
_ORTHONORMAL = 1e-6


@dataclass(frozen=True, eq=False)
class MeasuredState(FrozenArrays):
    """Where things are, as the sensors say, all fingers resting on the tool.

    Attributes:
        q: (nv,) joint positions [rad] or [m].
        tool_position: (3,) centre of mass, world [m].
        tool_rotation: (3, 3) world <- tool.
    """

    q: Array
    tool_position: Array
    tool_rotation: Array


@dataclass(frozen=True)
class Correction:
    """How far a measured state is from the planned one.

    Attributes:
        pivot_m: of the tip along the table [m].
        turn_rad: of the tool [rad].
        contacts_m: by finger, along the tool's surface [m].
        joints_rad: largest of a joint [rad] or [m].
    """

    pivot_m: float
    turn_rad: float
    contacts_m: Mapping[str, float]
    joints_rad: float


@dataclass(frozen=True, eq=False)
class Continuation:
    """The rest of a gait.

    Attributes:
        plan: whose phases are those that remain, with their names in the whole gait.
        correction: from the planned to the measured state.
    """

    plan: GaitPlan
    correction: Correction


def continue_gait(
    plan: GaitPlan,
    scene: Scene,
    configs: Sequence[PhaseConfig],
    measured: MeasuredState,
    *,
    options: HandOptions | None = None,
) -> Continuation:
    """Plan what remains of a gait from a measured state.

    The tip is taken to stand on the table where it is measured, which moves the pivot; the tool
    to be turned as measured; each finger to touch where its tip is, seen from the tool, on the
    plane through its planned contact (a slip of a few millimetres). Forces are allocated anew for
    this grasp. The planned fingertip still lies at the tool's surface, whatever the measured
    distance: that is for the impedance.

    Args:
        plan: of the whole gait or of its last phases, with a robot.
        scene: of the plan, with the same robot.
        configs: the whole gait's phases; the plan's are the last of them.
        measured: the state before one of the plan's phases.
        options: of the hand's motion.

    Returns:
        The rest of the gait, whose first phase is the plan's first.

    Raises:
        InputError: values that are not finite or of a wrong shape; a plan whose phases are not
            the last of the gait, or which starts while a finger is in the air.
        InfeasibleError: the gait cannot go on from there.
        SolverError: a solver failed otherwise.
    """
    robot = scene.robot
    if robot is None or plan.robot is None:
        raise InputError("has no robot", where="plan", mend="plan a scene with a robot")
    _check_state(measured, robot)
    done = _done(plan, configs)
    rotation = Rotation.from_matrix(measured.tool_rotation)
    scene = _standing(scene, rotation, measured.tool_position)
    held = _where_held(plan, scene, robot, rotation, measured.q, resting_on(scene, configs[:done]))
    setting = Setting.of(scene)
    grasp = Grasp(rotation, held, _forces(setting, rotation, held))
    steps = plan_steps(setting, configs[done:], start=grasp, first=done)
    rng = np.random.default_rng([plan.seed, done])
    found = HandPlanner(setting, robot, steps, rng, options).continue_like(plan.phases, measured.q)
    weak = weakest_joint(robot, found)
    if weak is not None:
        name, joint, share = weak
        raise InfeasibleError(f"needs {100 * share:.0f} % of the torque of {joint}", where=name)
    rest = replace(plan, phases=found.phases, certificate=None)
    return Continuation(rest, _correction(plan, scene, grasp, measured.q))


def resting_on(scene: Scene, configs: Sequence[PhaseConfig]) -> dict[str, HandleContact]:
    """Finger -> contact of all that hold the tool after some phases, in the order they came.

    Args:
        scene: of the gait.
        configs: its phases so far, the last one an addition.

    Raises:
        InputError: if the last one is no addition.
    """
    if not configs or not isinstance(configs[-1], AdditionPhase):
        what = "a gait is continued after an addition, when every finger rests on the tool"
        raise InputError(what, where="rest of the gait", mend="start it after an addition")
    held: dict[str, HandleContact] = {}
    for config in configs:
        if isinstance(config, LiftPhase):
            held = {scene.contacts[each].finger: scene.contacts[each] for each in config.contacts}
        elif isinstance(config, RemovalPhase):
            del held[scene.contacts[config.contact].finger]
        elif isinstance(config, AdditionPhase):
            contact = scene.contacts[config.contact]
            held[contact.finger] = contact
    return held


def _done(plan: GaitPlan, configs: Sequence[PhaseConfig]) -> int:
    """Number of the gait's phases before those of the plan."""
    done = len(configs) - len(plan.phases)
    kinds = [config.kind for config in configs]
    if done < 0 or kinds[done:] != [phase.kind for phase in plan.phases]:
        what = "its phases are not the last of the gait"
        raise InputError(what, where="plan", mend="give the phases that remain")
    return done


def _check_state(measured: MeasuredState, robot: Robot) -> None:
    shapes = measured.q.shape, measured.tool_position.shape, measured.tool_rotation.shape
    if shapes != ((robot.nv,), (3,), (3, 3)):
        what = f"shapes {shapes}, not (({robot.nv},), (3,), (3, 3))"
        raise InputError(what, where="measured state", mend="give q, position and rotation")
    turn = measured.tool_rotation
    values = np.concatenate((measured.q, measured.tool_position, turn.ravel()))
    if not np.isfinite(values).all() or np.abs(turn @ turn.T - np.eye(3)).max() > _ORTHONORMAL:
        what = "is not finite, or the rotation is none"
        raise InputError(what, where="measured state", mend="look for NaN")


def _standing(scene: Scene, rotation: Rotation, position: Array) -> Scene:
    """The scene with the pivot where the tip is measured to be on the table."""
    tip = position + rotation.as_matrix() @ scene.tool.pivot_in_tool
    pivot = np.array([*tip[:2], scene.pivot[2]])
    return replace(scene, pivot=pivot, clearance=_CLEARANCE_SHARE * scene.clearance)


def _where_held(
    plan: GaitPlan,
    scene: Scene,
    robot: Robot,
    rotation: Rotation,
    q: Array,
    held: Mapping[str, HandleContact],
) -> Mapping[str, HandleContact]:
    """The contacts in whose planes the fingertips are, normals as planned."""
    first, data = plan.phases[0], robot.model.createData()
    pin.forwardKinematics(robot.model, data, q)
    turn, place = rotation.as_matrix(), scene.centre_of_mass(rotation)
    found = {}
    for name, contact in held.items():
        finger, planned = robot.fingers[name], first.contacts[name].point
        tip = pin.updateFramePlacement(robot.model, data, finger.tip_frame_id).translation
        way = turn.T @ (tip - place) + finger.tip_radius * contact.normal - planned
        along = way - (way @ contact.normal) * contact.normal
        found[name] = replace(contact, point=planned + along)
    return MappingProxyType(found)


def _forces(
    setting: Setting, rotation: Rotation, held: Mapping[str, HandleContact]
) -> Mapping[str, Array]:
    """Forces that hold the tool at rest, by contact, world [N] (Xue et al., eq. 4)."""
    problem = allocation_problem(setting, resting_tool(setting, rotation, 1), [*held.values()])
    force = allocate(problem).require().force[0]
    return MappingProxyType(dict(zip((PIVOT, *held), force, strict=True)))


def _correction(plan: GaitPlan, scene: Scene, grasp: Grasp, q: Array) -> Correction:
    first = plan.phases[0]
    assert first.robot is not None
    turn = first.tool.rotation[0].inv() * grasp.rotation
    moved = {
        name: float(np.linalg.norm(contact.point - first.contacts[name].point))
        for name, contact in grasp.fingers.items()
    }
    return Correction(
        pivot_m=float(np.linalg.norm(scene.pivot - first.contacts[PIVOT].point)),
        turn_rad=float(turn.magnitude()),
        contacts_m=moved,
        joints_rad=float(np.abs(q - first.robot.q[0]).max()),
    )
