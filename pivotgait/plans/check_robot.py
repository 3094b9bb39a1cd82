"""Rules of form for the arm-hand of a plan: names, sizes, and motion in every phase or none."""

from __future__ import annotations

from pivotgait.exceptions import PlanFileError
from pivotgait.plans.check_values import check_array, check_finite
from pivotgait.plans.layout import (
    JOINT_MOTION,
    MAX_FINGERS,
    MAX_JOINTS,
    MAX_NAME_BYTES,
    MAX_PAIRS,
    is_contact_name,
)
from pivotgait.plans.plan import PIVOT, GaitPlan, Phase, PlannedFinger, PlannedRobot


def check_robot(plan: GaitPlan, where: str) -> None:
    """Refuse a robot whose values cannot be meant, and phases that do not fit to it.

    Args:
        plan: whose phases and contacts have been checked.
        where: name of the plan in messages.

    Raises:
        PlanFileError: naming the field, the value and the way to mend it.
    """
    if plan.robot is None:
        moving = [phase.name for phase in plan.phases if phase.robot is not None]
        if moving:
            raise PlanFileError(
                "moves a robot that the plan does not have",
                where=f"{where}: phase {moving[0]}",
                mend="give the plan its robot",
            )
        return
    _check_names(plan.robot, f"{where}: robot")
    _check_pairs(plan.robot, f"{where}: robot")
    for phase in plan.phases:
        _check_phase(phase, plan.robot, f"{where}: phase {phase.name}")


def _check_names(robot: PlannedRobot, where: str) -> None:
    count = len(robot.joint_names)
    if not 1 <= count <= MAX_JOINTS:
        raise PlanFileError(
            f"has {count} joints", where=where, mend=f"1 to {MAX_JOINTS} are allowed"
        )
    for name in robot.joint_names:
        _check_name(name, f"{where}: joint_names")
    if len(set(robot.joint_names)) != count:
        raise PlanFileError("two joints have one name", where=where, mend="rename one")
    if not 1 <= len(robot.fingers) <= MAX_FINGERS:
        raise PlanFileError(
            f"has {len(robot.fingers)} fingers", where=where, mend=f"1 to {MAX_FINGERS} are allowed"
        )
    for name, finger in robot.fingers.items():
        if name == PIVOT or not is_contact_name(name):
            raise PlanFileError(f"finger {name!r} cannot be used", where=where, mend="rename it")
        _check_finger(finger, f"{where}: finger {name}")
    frames = [finger.tip_frame for finger in robot.fingers.values()]
    if len(set(frames)) != len(frames):
        raise PlanFileError("two fingers have one tip_frame", where=where, mend="part them")


def _check_finger(finger: PlannedFinger, where: str) -> None:
    _check_name(finger.tip_frame, f"{where} tip_frame")
    check_finite(finger.tip_radius, f"{where} tip_radius")
    if not finger.tip_radius > 0.0:
        raise PlanFileError(
            f"tip_radius is {finger.tip_radius:g} m", where=where, mend="it must be positive"
        )


def _check_pairs(robot: PlannedRobot, where: str) -> None:
    for field in ("couplings", "never_touch"):
        pairs = getattr(robot, field)
        if len(pairs) > MAX_PAIRS:
            raise PlanFileError(
                f"{field} holds {len(pairs)} pairs", where=where, mend=f"at most {MAX_PAIRS}"
            )
        for pair in pairs:
            if len(pair) != 2 or pair[0] == pair[1]:
                raise PlanFileError(
                    f"{field} holds {pair!r}", where=where, mend="pairs of two different names"
                )
            for name in pair:
                _check_name(name, f"{where}: {field}")
    unknown = {name for pair in robot.couplings for name in pair} - set(robot.joint_names)
    if unknown:
        raise PlanFileError(
            f"couplings name the unknown joint {min(unknown)!r}",
            where=where,
            mend="use names of joint_names",
        )


def _check_phase(phase: Phase, robot: PlannedRobot, where: str) -> None:
    if phase.robot is None:
        raise PlanFileError("lacks the motion of the robot", where=where, mend="add q, v, a, tau")
    shape = (phase.time.size, len(robot.joint_names))
    for field in JOINT_MOTION:
        check_array(getattr(phase.robot, field), shape, f"{where}: robot/{field}")
    named = {*phase.contacts, phase.finger} - {PIVOT, ""}
    unknown = named - set(robot.fingers)
    if unknown:
        raise PlanFileError(
            f"finger {min(unknown)!r} is not one of the robot's",
            where=where,
            mend=f"has: {', '.join(robot.fingers)}",
        )
    if phase.kind == "relocation" and phase.finger not in robot.fingers:
        raise PlanFileError(
            "does not name the finger that moves",
            where=where,
            mend=f"one of {', '.join(robot.fingers)}",
        )


def _check_name(name: object, where: str) -> None:
    if not isinstance(name, str) or not 1 <= len(name.encode("utf-8", "replace")) <= MAX_NAME_BYTES:
        raise PlanFileError(
            f"name {name!r:.60} cannot be used", where=where, mend=f"1 to {MAX_NAME_BYTES} bytes"
        )
