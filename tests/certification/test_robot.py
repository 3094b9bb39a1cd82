"""A valid plan with an arm-hand passes; each single change of it is named, and nothing else is."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pivotgait.certification import (
    LIMITS,
    ROBOT_LIMITS,
    TOOL_LIMITS,
    TRANSFER_LIMITS,
    Certificate,
    certify,
    with_clearance,
)
from pivotgait.exceptions import PivotGaitError
from pivotgait.plans import GaitPlan, write_plan
from tests.certification.gantry import with_gantry

Mutation = Callable[[GaitPlan], GaitPlan]
LIFT, APPROACH, ADDITION, REMOVAL, RELOCATION, LAST = range(6)
ALL = slice(None)


def named(certificate: Certificate) -> set[str]:
    return {violation.what for violation in certificate.violations}


def in_joint(places: list[int], field: str, k: int | slice, joint: str, change: float) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        phases, column = list(plan.phases), plan.robot.joint_names.index(f"{joint}_joint")
        for place in places:
            motion = phases[place].robot
            array = np.array(getattr(motion, field))
            array[k, column] += change
            phases[place] = replace(phases[place], robot=replace(motion, **{field: array}))
        return replace(plan, phases=tuple(phases))

    return mutate


def in_robot(**changes: object) -> Mutation:
    return lambda plan: replace(plan, robot=replace(plan.robot, **changes))


def in_urdf(old: str, new: str) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        assert old in plan.robot.urdf
        return in_robot(urdf=plan.robot.urdf.replace(old, new))(plan)

    return mutate


def in_finger(name: str, **changes: object) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        finger = replace(plan.robot.fingers[name], **changes)
        return in_robot(fingers={**plan.robot.fingers, name: finger})(plan)

    return mutate


def shape(name: str, text: str) -> str:
    """Start of the URDF's element for a shape, up to what its origin says."""
    return f'<collision name="{name}">\n      <origin xyz="{text}"'


MUTATIONS: dict[str, tuple[Mutation, set[str]]] = {
    "held tip beside its contact": (
        in_joint([ADDITION], "q", ALL, "thumb_slide_x", 1.5e-5),
        {"tip_contact_m", "seam_joint"},
    ),
    "tip slides over the tool": (
        in_joint([ADDITION, REMOVAL, RELOCATION, LAST], "q", ALL, "thumb_slide_x", 2.5e-5),
        {"tip_contact_m", "tip_slip_m", "seam_joint"},
    ),
    "leaving finger leaves before the end": (
        in_joint([REMOVAL], "q", -1, "index_slide_x", 1.5e-5),
        {"tip_contact_m", "seam_joint"},
    ),
    "coming finger is not there from the start": (
        in_joint([LAST], "q", 0, "index_slide_x", 1.5e-5),
        {"tip_contact_m", "seam_joint", "joint_step_excess"},
    ),
    "tip has rolled since an earlier phase": (
        in_joint([REMOVAL, RELOCATION, LAST], "q", ALL, "thumb_hinge_x", 1.5e-4),
        {"tip_rolling_rad", "seam_joint"},
    ),
    "tip's velocity": (
        in_joint([REMOVAL], "v", 9, "thumb_slide_x", 2e-6),
        {"tip_velocity_m_s"},
    ),
    "tip rolls on": (
        in_joint([REMOVAL], "v", 9, "thumb_hinge_x", 1e-3),
        {"tip_velocity_m_s"},
    ),
    "tip's acceleration": (
        in_joint([REMOVAL], "a", 9, "thumb_slide_x", 2e-4),
        {"tip_acceleration_m_s2", "torque_balance_nm"},
    ),
    "tip's radius": (
        in_finger("index", tip_radius=0.00502),
        {"tip_radius_m", "tip_contact_m", "tip_velocity_m_s", "torque_balance_nm"},
    ),
    "tip larger than planned": (
        in_urdf('<sphere radius="0.005"/>', '<sphere radius="0.00502"/>'),
        {"tip_radius_m", "tip_penetration_m"},
    ),
    "tip that is no sphere": (
        in_urdf('<sphere radius="0.005"/>', '<box size="0.007 0.007 0.007"/>'),
        {"tip_radius_m"},
    ),
    "joint beyond its limits": (
        in_urdf('upper="1.5"', 'upper="0.4"'),
        {"joint_position"},
    ),
    "joint too fast": (in_urdf('velocity="3"', 'velocity="0.3"'), {"joint_speed"}),
    "joint too weak": (in_urdf('effort="50"', 'effort="5"'), {"joint_torque"}),
    "coupling": (
        in_robot(couplings=(("middle_slide_x_joint", "index_slide_x_joint"),)),
        {"joint_coupling"},
    ),
    "one position": (
        in_joint([RELOCATION], "q", 12, "thumb_slide_x", 1e-6),
        {"joint_step_excess"},
    ),
    "one speed": (
        in_joint([RELOCATION], "v", 12, "thumb_slide_x", 5e-7),
        {"joint_step_excess", "joint_rate_excess"},
    ),
    "moving at the end": (
        in_joint([APPROACH], "v", -1, "middle_slide_y", 1e-7),
        {"joint_rest"},
    ),
    "torque": (in_joint([LIFT], "tau", 3, "thumb_hinge_z", 2e-6), {"torque_balance_nm"}),
    "gravity forgotten": (
        in_joint([LIFT], "tau", ALL, "middle_slide_z", -9.81 * 0.65),
        {"torque_balance_nm"},
    ),
    "force forgotten": (
        lambda plan: without_reaction(plan, 1.0),
        {"torque_balance_nm"},
    ),
    "reaction with the wrong sign": (
        lambda plan: without_reaction(plan, 2.0),
        {"torque_balance_nm"},
    ),
    "moving finger in the tool": (
        lambda plan: with_gantry(bare(plan), bump=-1e-3),
        {"tip_penetration_m", "hand_clearance_m"},
    ),
    "moving finger along the tool": (
        lambda plan: with_gantry(bare(plan), bump=0.0),
        {"hand_clearance_m"},
    ),
    "idle finger at the tool": (
        lambda plan: with_gantry(bare(plan), hover=5e-4),
        {"hand_clearance_m"},
    ),
    "stem in the table": (
        in_urdf(shape("thumb_stem", "0 0.022 0"), shape("thumb_stem", "0 0.022 -0.05")),
        {"hand_clearance_m"},
    ),
}


def bare(plan: GaitPlan) -> GaitPlan:
    """The plan without robot and without the relocation that came with it."""
    phases = [phase for place, phase in enumerate(plan.phases) if place != APPROACH]
    phases = [replace(p, robot=None, name=f"{k:02d}_{p.kind}") for k, p in enumerate(phases)]
    return replace(plan, robot=None, phases=tuple(phases))


def without_reaction(plan: GaitPlan, share: float) -> GaitPlan:
    """The plan with ``share`` of J^T f missing from the thumb's slides, whose J is the identity."""
    mutated = plan
    for axis, name in enumerate("xyz"):
        column = plan.robot.joint_names.index(f"thumb_slide_{name}_joint")
        phases = list(mutated.phases)
        for place, phase in enumerate(phases):
            tau = np.array(phase.robot.tau)
            tau[:, column] -= share * phase.contacts["thumb"].force[:, axis]
            phases[place] = replace(phase, robot=replace(phase.robot, tau=tau))
        mutated = replace(mutated, phases=tuple(phases))
    return mutated


def test_valid_plan_is_valid_far_inside_its_limits(robot_plan: GaitPlan) -> None:
    certificate = certify(robot_plan)
    assert certificate.valid, certificate.violations
    on_table = {*TOOL_LIMITS, *ROBOT_LIMITS}
    assert certificate.residuals.keys() == on_table == LIMITS.keys() - TRANSFER_LIMITS.keys()
    shares = {"joint_speed", "joint_torque"}
    identities = {what for what in on_table if not LIMITS[what].at_least}
    assert max(certificate.residuals[what] for what in identities - shares) < 1e-12


def test_plan_without_robot_is_not_asked_for_one(valid_plan: GaitPlan) -> None:
    assert certify(valid_plan).residuals.keys() == TOOL_LIMITS.keys()


def test_file_and_memory_agree(robot_plan: GaitPlan, tmp_path) -> None:
    write_plan(robot_plan, tmp_path / "plan.h5")
    assert certify(tmp_path / "plan.h5").as_json() == certify(robot_plan).as_json()


@pytest.mark.parametrize("name", MUTATIONS)
def test_single_change_is_named(robot_plan: GaitPlan, name: str) -> None:
    mutate, expected = MUTATIONS[name]
    certificate = certify(mutate(robot_plan))
    assert named(certificate) == expected
    assert not certificate.valid


def test_every_limit_is_missed_by_some_change() -> None:
    """No check that cannot fail."""
    covered = set().union(*(expected for _, expected in MUTATIONS.values()))
    assert covered == set(ROBOT_LIMITS)


def worst(plan: GaitPlan, what: str):
    return certify(plan).findings[what]


def test_the_joint_and_its_time_are_named(robot_plan: GaitPlan) -> None:
    plan = in_joint([LIFT], "tau", 3, "thumb_hinge_z", 1.0)(robot_plan)
    (violation,) = certify(plan).violations
    assert (violation.phase, violation.part) == ("00_lift", "thumb_hinge_z_joint")
    assert violation.time_s == plan.phases[LIFT].time[3]
    data = json.loads(json.dumps(certify(plan).as_json(), allow_nan=False))
    assert data["violations"][0]["part"] == "thumb_hinge_z_joint"
    assert "part" not in data["worst"]["force_balance_n"]


@pytest.mark.parametrize(
    ("name", "old", "new", "links"),
    [
        ("thumb_stem", "0 0.022 0", "0 0.022 -0.05", "thumb_hinge_z - table"),
        ("thumb_stem", "0 0.022 0", "0 -0.01 0", "thumb_hinge_z - tool"),
        ("index_stem", "0 -0.022 0", "0.012 -0.022 0", "index_hinge_z - middle_tip"),
        ("frame", "-0.3 0 0", "0.43 0.18 0", "frame - thumb_hinge_z"),
    ],
)
def test_links_that_collide_are_named(
    robot_plan: GaitPlan, name: str, old: str, new: str, links: str
) -> None:
    mutate = in_urdf(shape(name, old), shape(name, new))
    certificate = certify(mutate(robot_plan))
    assert named(certificate) == {"hand_clearance_m"}
    assert certificate.findings["hand_clearance_m"].part == links


def test_tip_that_comes_too_near_is_named(robot_plan: GaitPlan) -> None:
    """Far from where it lands, a moving tip keeps the clearance like any other link."""
    found = worst(with_gantry(bare(robot_plan), bump=5e-4), "hand_clearance_m")
    assert (found.phase, found.contact) == ("04_relocation", "index")
    assert found.part == "index_tip - tool"
    assert found.value < 1e-3


def test_links_that_never_touch_do_not_count(robot_plan: GaitPlan) -> None:
    thick = in_urdf('radius="0.003"', 'radius="0.0072"')(robot_plan)
    pair = ("middle_hinge_z", "index_hinge_z")
    (part,) = {violation.part for violation in certify(thick).violations}
    assert set(part.split(" - ")) == set(pair)
    assert certify(in_robot(never_touch=(pair,))(thick)).valid


def test_clearance_can_be_asked_for(robot_plan: GaitPlan) -> None:
    has = worst(robot_plan, "hand_clearance_m").value
    assert certify(robot_plan, limits=with_clearance(has - 1e-6)).valid
    assert named(certify(robot_plan, limits=with_clearance(has + 1e-6))) == {"hand_clearance_m"}
    asked = replace(robot_plan, scene=f"clearance_m: {has + 1e-6!r}\n")
    assert named(certify(asked)) == {"hand_clearance_m"}


UNFIT: dict[str, tuple[Mutation, str]] = {
    "joints in another order": (
        lambda plan: in_robot(joint_names=plan.robot.joint_names[::-1])(plan),
        "order",
    ),
    "unknown tip frame": (in_finger("index", tip_frame="toe"), "toe"),
    "unknown link": (in_robot(never_touch=(("index_tip", "toe"),)), "toe"),
    "fixed joint": (in_urdf('name="index_hinge_z_joint" type="revolute"',
                            'name="index_hinge_z_joint" type="fixed"'), "order"),
    "mesh": (in_urdf('<sphere radius="0.005"/>', '<mesh filename="a.stl"/>'), "robot of the plan"),
    "no URDF": (in_robot(urdf="<robot"), "robot of the plan"),
    "planets": (in_urdf('<sphere radius="0.005"/>', '<sphere radius="1e300"/>'), "length"),
    "far away": (in_urdf('<origin xyz="-0.3 0 0"', '<origin xyz="1e200 0 0"'), "length"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNFIT)
def test_unusable_robot_is_refused(robot_plan: GaitPlan, name: str) -> None:
    mutate, says = UNFIT[name]
    with pytest.raises(PivotGaitError, match=says) as caught:
        certify(mutate(robot_plan))
    assert caught.value.exit_code == 2


def test_robot_of_one_phase_only_is_refused(robot_plan: GaitPlan) -> None:
    phases = (replace(robot_plan.phases[0], robot=None), *robot_plan.phases[1:])
    with pytest.raises(PivotGaitError, match="00_lift"):
        certify(replace(robot_plan, phases=phases))


def test_contact_of_a_finger_that_the_robot_lacks(robot_plan: GaitPlan) -> None:
    fingers = {name: each for name, each in robot_plan.robot.fingers.items() if name != "middle"}
    with pytest.raises(PivotGaitError, match="middle"):
        certify(in_robot(fingers=fingers)(robot_plan))


def test_extreme_postures_end_in_a_certificate(robot_plan: GaitPlan) -> None:
    """Positions at the edge of what a file may hold: judged, neither free nor a crash."""
    for size in (1e6, 9e11):
        certificate = certify(in_joint([LIFT], "q", ALL, "middle_slide_x", size)(robot_plan))
        assert "joint_position" in named(certificate)
        json.dumps(certificate.as_json(), allow_nan=False)
