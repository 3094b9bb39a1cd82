"""The last test of a sequence: the planners of all its phases, the hand's, and the certificate."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from pivotgait.certification import Certificate, certify
from pivotgait.exceptions import InfeasibleError, PivotGaitError, SolverError
from pivotgait.frozen import Array
from pivotgait.gait_search.cost import Cost, CostWeights
from pivotgait.gait_search.found_scene import FoundScene
from pivotgait.gait_search.goals import Goal
from pivotgait.gait_search.palm import PalmDistance
from pivotgait.gait_search.states import Move
from pivotgait.gait_search.static_tests import grasp_depths
from pivotgait.gaits import plan_gait
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import HandleContact, Robot, Scene
from pivotgait.planning.posture_search import PostureOptions
from pivotgait.plans import GaitPlan, Phase

_PHASE = re.compile(r"\b(?P<place>\d\d)_[a-z]+")
_NUMBER = re.compile(r"-?\d[\d.e+-]*")
_TOOL = "phases"
_HAND = "hand's motion"


@dataclass(frozen=True, eq=False)
class FoundGait:
    """A sequence that plans and certifies.

    Attributes:
        found: its scene.
        moves: from the table to the goal.
        plan: with the certificate.
        certificate: valid.
        cost: measured on the plan.
        estimate: of the search.
        palm_m: distance of the palm from the handle's axis at the end [m]; NaN without a robot.
    """

    found: FoundScene
    moves: tuple[Move, ...]
    plan: GaitPlan
    certificate: Certificate
    cost: Cost
    estimate: Cost
    palm_m: float


@dataclass(frozen=True)
class Failed:
    """Why a sequence has no certified plan.

    Attributes:
        stage: of :data:`pivotgait.gait_search.deaths.STAGES`.
        reason: without numbers, so that equal ones count together.
        move: place of the move that cannot be made whatever follows; -1 if that is not known.
    """

    stage: str
    reason: str
    move: int = -1


def plan_fully(
    found: FoundScene,
    moves: Sequence[Move],
    goal: Goal,
    weights: CostWeights,
    *,
    seed: int,
    starts: int,
) -> FoundGait | Failed:
    """Plan the gait of a found scene as ``pivotgait plan`` does, and certify it.

    Args:
        found: scene of the sequence.
        moves: of the sequence.
        goal: says how near the palm must be in the end.
        weights: of the cost.
        seed: of the plan.
        starts: most starts of the search for postures.
    """
    scene = found.scene
    options = HandOptions(PostureOptions(starts=starts, time_limit_s=np.inf))
    try:
        plan = plan_gait(scene, seed=seed, options=options)
    except (InfeasibleError, SolverError) as error:
        return _failure(error, found.move_of)
    certificate = certify(plan)
    if not certificate.valid:
        return Failed("certificate", certificate.violations[0].what)
    palm = float("nan")
    if scene.robot is not None:
        palm = palm_at_end(scene, scene.robot, plan)
        if palm > goal.palm_max_m:
            return Failed("palm", "too far from the handle")
    estimate = sum((move.cost for move in moves), Cost())
    cost = measured_cost(scene, plan, weights)
    return FoundGait(found, tuple(moves), plan, certificate, cost, estimate, palm)


def measured_cost(scene: Scene, plan: GaitPlan, weights: CostWeights) -> Cost:
    """What a plan costs, in the search's terms."""
    cost = Cost()
    for phase in plan.phases:
        turned = float(np.radians(phase.reorientation_deg))
        cost += Cost(turned, time_s=phase.duration_s)
        if phase.kind == "relocation" and scene.robot is not None:
            cost += Cost(path_m=_tip_path(scene.robot, phase))
        elif phase.kind != "transfer":
            cost += Cost(shortfall=weights.shortfall(_depth_at_end(scene, phase)))
    return cost


def palm_at_end(scene: Scene, robot: Robot, plan: GaitPlan) -> float:
    """Distance of the palm from the handle's axis in the plan's last moment [m]."""
    last = plan.phases[-1]
    assert last.robot is not None
    rotation = last.tool.rotation[-1].as_matrix()
    return PalmDistance(robot, scene.tool)(last.robot.q[-1], rotation, last.tool.position[-1])


def _depth_at_end(scene: Scene, phase: Phase) -> float:
    """How far inside the limits the fingers that hold at a phase's end can be [N]."""
    held = [
        HandleContact(
            name,
            name,
            track.point,
            track.normal,
            track.friction,
            max(track.normal_min, _least(scene, name)),
            track.normal_max,
        )
        for name, track in phase.contacts.items()
        if not track.is_pivot and not (phase.kind == "removal" and name == phase.finger)
    ]
    rotation: Rotation = phase.tool.rotation[-1]
    return float(grasp_depths(scene, [held], rotation)[0])


def _least(scene: Scene, finger: str) -> float:
    """Least force of a finger that has come, which a coming one's track does not tell."""
    return min(each.normal_min for each in scene.contacts.values() if each.finger == finger)


def _tip_path(robot: Robot, phase: Phase) -> float:
    """Way of the moving fingertip [m]; the tool rests meanwhile."""
    assert phase.robot is not None
    data, frame = robot.model.createData(), robot.fingers[phase.finger].tip_frame_id
    places = np.zeros((len(phase.time), 3))
    for k, q in enumerate(phase.robot.q):
        pin.framesForwardKinematics(robot.model, data, np.array(q))
        places[k] = data.oMf[frame].translation
    steps: Array = np.linalg.norm(np.diff(places, axis=0), axis=1)
    return float(steps.sum())


def _failure(error: PivotGaitError, move_of: Sequence[int]) -> Failed:
    named = _PHASE.search(error.where)
    reason = " ".join(_NUMBER.sub("", _PHASE.sub("", error.what)).split())[:80]
    if named is None:
        return Failed(_HAND, reason)
    return Failed(_TOOL, reason, move_of[int(named["place"])])
