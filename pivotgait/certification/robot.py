"""Everything that the certificate says of the arm-hand, from the plan alone."""

from __future__ import annotations

from collections.abc import Iterator

from pivotgait.certification.certificate import Finding
from pivotgait.certification.hand_clearance import check_hand_clearance
from pivotgait.certification.holds import Holds
from pivotgait.certification.joint_sampling import check_joint_sampling
from pivotgait.certification.joints import check_joint_seams, check_joints
from pivotgait.certification.rigid_robot import check_tip_radii, rigid_robot
from pivotgait.certification.solid import RigidTool
from pivotgait.certification.surroundings import Surroundings
from pivotgait.certification.tips import tip_motions
from pivotgait.certification.torques import check_torques
from pivotgait.plans import GaitPlan, PlannedRobot


def check_robot(
    plan: GaitPlan, planned: PlannedRobot, tool: RigidTool, clearance: float
) -> Iterator[Finding]:
    """Model, holds, joints, torques and clearance of a plan with an arm-hand.

    Args:
        plan: the plan, checked.
        planned: its robot.
        tool: the tool of its URDF.
        clearance: smallest distance outside the wanted contacts [m].

    Raises:
        UrdfError: if the robot's URDF must not reach the native parsers.
        PlanFileError: if URDF and plan do not name the same joints and links.
    """
    rigid = rigid_robot(planned)
    yield from check_tip_radii(planned, rigid)
    surroundings = Surroundings(plan, planned, rigid, tool)
    holds = Holds(planned.fingers)
    for phase in plan.phases:
        motion = phase.robot
        if motion is None:
            continue  # no plan that passed check_plan
        tips = tip_motions(rigid, motion)
        yield from holds.check(phase, tips)
        yield from check_joints(planned, rigid, phase, motion)
        yield from check_joint_sampling(phase, motion, rigid.joint_names)
        yield check_torques(plan, planned, rigid, phase, motion)
        yield from check_hand_clearance(phase, motion, tips, surroundings, clearance)
    yield from check_joint_seams(plan, rigid)
