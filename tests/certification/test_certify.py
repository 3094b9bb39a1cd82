"""A valid plan passes; each single change of it is named, and nothing else is."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.certification import TOOL_LIMITS, Certificate, certify, with_clearance
from pivotgait.exceptions import PivotGaitError
from pivotgait.plans import GaitPlan, write_plan

Mutation = Callable[[GaitPlan], GaitPlan]
LIFT, ADDITION, REMOVAL, RELOCATION, LAST = range(5)


def named(certificate: Certificate) -> set[str]:
    return {violation.what for violation in certificate.violations}


def in_phase(plan: GaitPlan, place: int, **changes: object) -> GaitPlan:
    phases = list(plan.phases)
    phases[place] = replace(phases[place], **changes)
    return replace(plan, phases=tuple(phases))


def in_motion(place: int, field: str, k: int, change: object) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        tool = plan.phases[place].tool
        array = np.array(getattr(tool, field))
        array[k] += change
        return in_phase(plan, place, tool=replace(tool, **{field: array}))

    return mutate


def in_contact(place: int, name: str, **changes: Callable[[np.ndarray], object]) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        contacts = dict(plan.phases[place].contacts)
        old = contacts[name]
        new = {field: change(np.array(getattr(old, field))) for field, change in changes.items()}
        contacts[name] = replace(old, **new)
        return in_phase(plan, place, contacts=contacts)

    return mutate


def everywhere(mutate_at: Callable[[int], Mutation], places: range | list[int]) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        for place in places:
            plan = mutate_at(place)(plan)
        return plan

    return mutate


def in_tool(**changes: Callable[[GaitPlan], object]) -> Mutation:
    return lambda plan: replace(
        plan, tool=replace(plan.tool, **{field: new(plan) for field, new in changes.items()})
    )


def bumped(k: int, change: object) -> Callable[[np.ndarray], np.ndarray]:
    def bump(array: np.ndarray) -> np.ndarray:
        array[k] += change
        return array

    return bump


def test_valid_plan_is_valid_far_inside_its_limits(valid_plan: GaitPlan) -> None:
    certificate = certify(valid_plan)
    assert certificate.valid, certificate.violations
    assert certificate.residuals.keys() == TOOL_LIMITS.keys()
    identities = [what for what, limit in TOOL_LIMITS.items() if not limit.at_least]
    assert max(certificate.residuals[what] for what in identities) < 1e-12


def test_file_and_memory_agree(valid_plan: GaitPlan, tmp_path) -> None:
    write_plan(valid_plan, tmp_path / "plan.h5")
    assert certify(tmp_path / "plan.h5").as_json() == certify(valid_plan).as_json()


UP = np.array([0.0, 0.0, 1.0])
ALONG_X = np.array([1.0, 0.0, 0.0])
ALONG_Y = np.array([0.0, 1.0, 0.0])

MUTATIONS: dict[str, tuple[Mutation, set[str]]] = {
    "pivot force": (
        in_contact(LIFT, "pivot", force=bumped(7, 1e-5 * UP)),
        {"force_balance_n", "moment_balance_nm"},
    ),
    "finger torque alone": (
        # Equal and opposite changes: the sum of forces stays, the moment does not.
        lambda plan: in_contact(LIFT, "index", force=bumped(7, -1e-4 * UP))(
            in_contact(LIFT, "thumb", force=bumped(7, 1e-4 * UP))(plan)
        ),
        {"moment_balance_nm"},
    ),
    "friction of one phase": (
        in_contact(RELOCATION, "thumb", friction=lambda mu: mu + 0.1),
        {"seam_friction"},
    ),
    "friction too low": (
        everywhere(lambda i: in_contact(i, "thumb", friction=lambda mu: mu * 0.02), range(5)),
        {"cone_margin_n"},
    ),
    "upper bound": (
        in_contact(LIFT, "thumb", normal_max=lambda _: 6.0),
        {"normal_bound_n"},
    ),
    "lower bound": (
        in_contact(LIFT, "index", normal_min=lambda _: 12.0),
        {"normal_bound_n"},
    ),
    "lower bound of the removed finger": (
        in_contact(REMOVAL, "index", normal_min=lambda _: 1.0),
        set(),  # (7) takes it through every value down to 0
    ),
    "lower bound of a finger that stays": (
        in_contact(REMOVAL, "pivot", normal_min=lambda _: 15.0),
        {"normal_bound_n"},
    ),
    "quaternion length": (
        lambda plan: in_phase(
            plan,
            LIFT,
            tool=replace(
                plan.phases[LIFT].tool,
                orientation=plan.phases[LIFT].tool.orientation * (1.0 + 1e-7),
            ),
        ),
        {"quaternion_norm"},
    ),
    "velocity": (in_motion(REMOVAL, "linear_velocity", 9, 1e-6), {"linear_velocity_m_s"}),
    "acceleration": (
        in_motion(REMOVAL, "linear_acceleration", 9, 1e-4),
        {"linear_acceleration_m_s2", "force_balance_n"},
    ),
    "angular velocity": (
        in_motion(REMOVAL, "angular_velocity", 9, 1e-4 * ALONG_X),
        {
            "linear_velocity_m_s",
            "linear_acceleration_m_s2",
            "rotation_excess_rad",
            "rate_excess_rad_s",
        },
    ),
    "angular acceleration": (
        in_motion(REMOVAL, "angular_acceleration", 9, 1e-4 * UP),
        {"linear_acceleration_m_s2", "rate_excess_rad_s"},
    ),
    "one orientation": (
        lambda plan: turned(plan, ADDITION, 12, 1e-7),
        {"position_m", "rotation_excess_rad"},
    ),
    "position": (
        in_motion(ADDITION, "position", 12, 1e-8),
        {"position_m"},
    ),
    "turning at the end": (
        in_motion(LIFT, "angular_velocity", -1, 1e-6 * UP),
        {"rest_rad_s", "linear_velocity_m_s"},
    ),
    "ramp": (
        in_contact(REMOVAL, "index", force=bumped(9, 1e-3 * UP)),
        {"ramp_n", "force_balance_n", "moment_balance_nm"},
    ),
    "finger that leaves under load": (
        in_contact(REMOVAL, "index", force=bumped(-1, 2e-6 * UP)),
        {"free_force_n", "cone_margin_n", "force_balance_n", "seam_force_n"},
    ),
    "pivot moves": (
        everywhere(
            lambda i: (
                lambda plan: in_contact(i, "pivot", point=lambda p: p + 1e-7 * ALONG_X)(
                    in_motion(i, "position", slice(None), 1e-7 * ALONG_X)(plan)
                )
            ),
            [RELOCATION, LAST],
        ),
        {"pivot_moved_m", "seam_position_m", "seam_contact_m"},
    ),
    "table normal": (
        in_contact(LAST, "pivot", normal=lambda _: np.array([0.0, np.sin(0.01), np.cos(0.01)])),
        {"table_normal"},
    ),
    "table height": (
        lambda plan: replace(plan, table_height=-1e-4),
        {"pivot_height_m"},
    ),
    "table too high": (
        lambda plan: replace(plan, table_height=0.004),
        {"pivot_height_m", "lift_clearance_m"},
    ),
    "contact off the surface": (
        everywhere(
            lambda i: in_contact(i, "middle", point=lambda p: p + 3e-6 * ALONG_Y), [1, 2, 3, 4]
        ),
        {"contact_surface_m", "moment_balance_nm"},
    ),
    "contact beside its last place": (
        in_contact(RELOCATION, "thumb", point=lambda p: p + 2e-9 * ALONG_X),
        {"seam_contact_m"},
    ),
    "contact normal": (
        in_contact(LIFT, "thumb", normal=lambda n: Rotation.from_rotvec(0.002 * UP).apply(n)),
        {"contact_normal_rad"},
    ),
    "normal's length": (
        in_contact(LIFT, "thumb", normal=lambda n: n * (1.0 + 1e-6)),
        {"normal_norm"},
    ),
    "mass": (
        in_tool(mass=lambda plan: plan.tool.mass * (1.0 + 1e-4)),
        {"tool_mass", "force_balance_n"},
    ),
    "inertia": (
        in_tool(inertia=lambda plan: plan.tool.inertia * (1.0 + 1e-6)),
        {"tool_inertia"},
    ),
    "impossible inertia": (
        in_tool(inertia=lambda plan: plan.tool.inertia - np.diag([1e-5, 0.0, 0.0])),
        {"tool_inertia", "tool_inertia_physical", "moment_balance_nm"},
    ),
    "centre of mass": (
        in_tool(centre_of_mass_in_root=lambda plan: plan.tool.centre_of_mass_in_root + 1e-8),
        {"tool_centre_m"},
    ),
    "pivot in tool": (
        in_tool(pivot_in_tool=lambda plan: plan.tool.pivot_in_tool + 2e-6 * UP),
        {
            "tool_pivot_m",
            "position_m",
            "linear_velocity_m_s",
            "linear_acceleration_m_s2",
            "table_clearance_m",  # a tip that is not at the pivot is no tip, and lies on the table
        },
    ),
    "gravity": (
        lambda plan: replace(plan, gravity=plan.gravity * 1.001),
        {"force_balance_n"},
    ),
    "a phase left out": (
        lambda plan: replace(
            plan, phases=(plan.phases[0], replace(plan.phases[3], name="01_relocation"))
        ),
        {"seam_force_n", "seam_orientation_rad", "seam_position_m"},
    ),
    "force at a seam": (
        lambda plan: squeezed(plan, RELOCATION, 1e-4),
        {"seam_force_n"},
    ),
}


def turned(plan: GaitPlan, place: int, k: int, angle: float) -> GaitPlan:
    """The plan with the tool turned by ``angle`` [rad] at one sample."""
    tool = plan.phases[place].tool
    orientation = np.array(tool.orientation)
    turn = Rotation.from_rotvec([0.0, angle, 0.0])
    orientation[k] = (turn * Rotation.from_quat(orientation[k])).as_quat()
    return in_phase(plan, place, tool=replace(tool, orientation=orientation))


def squeezed(plan: GaitPlan, place: int, size: float) -> GaitPlan:
    """The plan with two fingers pressing harder along the line between them [N]."""
    contacts = dict(plan.phases[place].contacts)
    thumb, middle = contacts["thumb"], contacts["middle"]
    line = plan.phases[place].tool.rotation.as_matrix() @ (middle.point - thumb.point)
    push = size * line / np.linalg.norm(line, axis=1, keepdims=True)
    contacts["thumb"] = replace(thumb, force=thumb.force + push)
    contacts["middle"] = replace(middle, force=middle.force - push)
    return in_phase(plan, place, contacts=contacts)


@pytest.mark.parametrize("name", MUTATIONS)
def test_single_change_is_named(valid_plan: GaitPlan, name: str) -> None:
    mutate, expected = MUTATIONS[name]
    certificate = certify(mutate(valid_plan))
    assert named(certificate) == expected
    assert certificate.valid == (not expected)


def test_every_limit_is_missed_by_some_change(valid_plan: GaitPlan) -> None:
    """No check that cannot fail."""
    covered = set().union(*(expected for _, expected in MUTATIONS.values()))
    assert covered == set(TOOL_LIMITS)


def test_violation_tells_phase_contact_and_time(valid_plan: GaitPlan) -> None:
    plan = in_contact(REMOVAL, "index", force=bumped(9, 1e-3 * UP))(valid_plan)
    ramp = next(each for each in certify(plan).violations if each.what == "ramp_n")
    assert (ramp.phase, ramp.contact) == ("02_removal", "index")
    assert ramp.time_s == plan.phases[REMOVAL].time[9]
    assert ramp.limit == TOOL_LIMITS["ramp_n"].bound < ramp.value


def test_relocating_finger_carries_nothing(valid_plan: GaitPlan) -> None:
    """A finger on its way that still pushes is named, also when (3) is balanced with it."""
    phase = valid_plan.phases[RELOCATION]
    index = valid_plan.phases[REMOVAL].contacts["index"]
    pushing = replace(index, force=np.tile([0.0, 0.1, 0.0], (len(phase.time), 1)))
    plan = in_phase(valid_plan, RELOCATION, contacts={**phase.contacts, "index": pushing})
    assert "free_force_n" in named(certify(plan))


def test_clearance_can_be_asked_for(valid_plan: GaitPlan) -> None:
    has = certify(valid_plan).residuals["table_clearance_m"]
    assert certify(valid_plan, limits=with_clearance(has - 1e-6)).valid
    assert named(certify(valid_plan, limits=with_clearance(has + 1e-6))) == {"table_clearance_m"}


@pytest.mark.parametrize("excess", [-1e-6, 1e-6])
def test_clearance_of_the_scene_counts(valid_plan: GaitPlan, excess: float) -> None:
    has = certify(valid_plan).residuals["table_clearance_m"]
    plan = replace(valid_plan, scene=f"clearance_m: {has + excess!r}\n")
    assert certify(plan).valid == (excess < 0.0)


@pytest.mark.parametrize("scene", ["clearance_m: -1", "clearance_m: .nan", "clearance_m: x", "[1"])
def test_scene_that_asks_for_nonsense_is_refused(valid_plan: GaitPlan, scene: str) -> None:
    with pytest.raises(PivotGaitError) as caught:
        certify(replace(valid_plan, scene=scene))
    assert caught.value.exit_code == 2


def test_finger_may_go_elsewhere_between_removal_and_addition(valid_plan: GaitPlan) -> None:
    """Without a relocation in the plan: the finger is free at the seam, so its place may change."""
    *first, _, last = valid_plan.phases
    plan = replace(valid_plan, phases=(*first, replace(last, name="03_addition")))
    assert np.any(last.contacts["index"].point != first[-1].contacts["index"].point)
    assert certify(plan).valid


def test_json_is_plain_and_complete(valid_plan: GaitPlan) -> None:
    broken = in_contact(LIFT, "pivot", force=bumped(7, 1e-5 * UP))(valid_plan)
    data = json.loads(json.dumps(certify(broken).as_json(), allow_nan=False))
    assert data["valid"] is False
    assert set(data["residuals"]) == set(data["tolerances"]) == set(TOOL_LIMITS)
    for violation in data["violations"]:
        assert {"phase", "what", "value", "limit"} <= set(violation)
        assert violation["phase"] == "00_lift"


@pytest.mark.parametrize(
    "urdf",
    ["", "<robot", "<robot name='x' version='1.1'></robot>", "\0", "<a>" * 10_000],
)
def test_unusable_urdf_is_refused(valid_plan: GaitPlan, urdf: str) -> None:
    with pytest.raises(PivotGaitError) as caught:
        certify(replace(valid_plan, tool=replace(valid_plan.tool, urdf=urdf)))
    assert caught.value.exit_code == 2


def test_nan_in_memory_is_refused(valid_plan: GaitPlan) -> None:
    with pytest.raises(PivotGaitError, match="finite"):
        certify(in_contact(LIFT, "pivot", force=bumped(3, np.nan))(valid_plan))
