"""Margins on forces whose margins are known by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.margins import gait_margins, smallest_margin
from pivotgait.plans import ContactTrack, GaitPlan, Phase, PlannedTool, ToolMotion

COUNT = 5
TIME = np.linspace(0.0, 2.0, COUNT)
TURN = Rotation.from_euler("ZYX", [0.3, -0.7, 1.1])
NORMAL = np.array([0.6, 0.0, -0.8])


def track(name: str, normal_force: object, sliding: object, **changes: float) -> ContactTrack:
    """Forces with given normal and tangential sizes, in a turned tool frame."""
    normal = np.array([0.0, 0.0, 1.0]) if name == "pivot" else NORMAL
    along = np.array([0.0, 1.0, 0.0])  # normal to both
    local = np.multiply.outer(np.broadcast_to(normal_force, COUNT), normal)
    local = local + np.multiply.outer(np.broadcast_to(sliding, COUNT), along)
    force = local if name == "pivot" else TURN.apply(local)
    bounds = {"friction": 0.5, "normal_min": 1.0, "normal_max": 9.0} | changes
    return ContactTrack(name, np.zeros(3), normal, force, **bounds)


def phase(place: int, kind: str, finger: str, *tracks: ContactTrack) -> Phase:
    zero = np.zeros((COUNT, 3))
    motion = ToolMotion(zero, np.tile(TURN.as_quat(), (COUNT, 1)), zero, zero, zero, zero)
    name = f"{place:02d}_{kind}"
    return Phase(name, kind, finger, TIME, motion, {each.name: each for each in tracks})


def plan_of(*phases: Phase) -> GaitPlan:
    tool = PlannedTool("rod", 0.1, np.eye(3), np.zeros(3), "", np.zeros(3))
    return GaitPlan("", 0, {}, np.array([0.0, 0.0, -9.81]), 0.0, tool, phases)


@pytest.fixture
def plan() -> GaitPlan:
    lift = phase(0, "lift", "", track("pivot", 5.0, 1.0), track("thumb", 5.0, [0, 1, 2, 1, 0]))
    ramp = np.linspace(4.0, 0.0, COUNT)
    removal = phase(
        1,
        "removal",
        "thumb",
        track("pivot", [5, 4, 3, 2, 3], 0.1),
        track("thumb", ramp, 0.3 * ramp),
    )
    return plan_of(lift, removal)


def test_values_by_hand(plan: GaitPlan) -> None:
    lift, removal = gait_margins(plan)
    np.testing.assert_allclose(lift.contacts["thumb"].friction, [1.0, 0.6, 0.2, 0.6, 1.0])
    np.testing.assert_allclose(lift.contacts["thumb"].above_min, 4.0)
    np.testing.assert_allclose(lift.contacts["thumb"].below_max, 4.0)
    np.testing.assert_allclose(removal.lift_off, [4, 3, 2, 1, 2])


def test_changing_finger_has_no_lower_margin_and_none_at_zero_force(plan: GaitPlan) -> None:
    thumb = gait_margins(plan)[1].contacts["thumb"]
    assert np.all(np.isnan(thumb.above_min))
    np.testing.assert_allclose(thumb.friction[:-1], 0.4)
    assert np.isnan(thumb.friction[-1])


def test_smallest_names_kind_contact_phase_and_time(plan: GaitPlan) -> None:
    least = smallest_margin(plan)
    assert (least.kind, least.contact, least.phase) == ("lift_off", "pivot", "01_removal")
    assert least.time_s == TIME[3]
    assert least.value == pytest.approx(1.0 / 8.0)
    slip = smallest_margin(plan, ["friction"])
    assert (slip.contact, slip.phase, slip.time_s) == ("thumb", "00_lift", TIME[2])
    assert slip.value == pytest.approx(0.2)
    assert json.loads(json.dumps(slip.as_json()))["kind"] == "friction"


def test_saturated_bound_counts_only_if_asked_for() -> None:
    plan = plan_of(phase(0, "lift", "", track("pivot", 5.0, 0.0), track("thumb", 9.0, 0.0)))
    assert smallest_margin(plan).kind == "lift_off"
    least = smallest_margin(plan, ["friction", "normal_max"])
    assert (least.kind, least.contact) == ("normal_max", "thumb")
    assert least.value == pytest.approx(0.0, abs=1e-12)


def test_violation_is_negative() -> None:
    plan = plan_of(phase(0, "lift", "", track("pivot", 0.5, 0.5)))
    assert smallest_margin(plan, ["friction"]).value == pytest.approx(-1.0)
    assert smallest_margin(plan, ["lift_off"]).value < 0.0


def test_margins_do_not_depend_on_the_frame(plan: GaitPlan) -> None:
    """Turning the tool and its forces together changes nothing."""
    turn = Rotation.from_rotvec([0.4, 1.0, -2.0])
    old = plan.phases[0]
    motion = replace(old.tool, orientation=(turn * old.tool.rotation).as_quat())
    thumb = old.contacts["thumb"]
    moved = replace(thumb, force=turn.apply(np.array(thumb.force)))
    turned = replace(old, tool=motion, contacts={"thumb": moved, "pivot": old.contacts["pivot"]})
    left, right = gait_margins(plan_of(old))[0], gait_margins(plan_of(turned))[0]
    np.testing.assert_allclose(
        left.contacts["thumb"].friction, right.contacts["thumb"].friction, atol=1e-12
    )


def test_no_force_no_margin() -> None:
    plan = plan_of(phase(0, "lift", "", track("pivot", 0.0, 0.0)))
    assert smallest_margin(plan, ["friction"]) is None


def test_arrays_are_read_only(plan: GaitPlan) -> None:
    with pytest.raises(ValueError, match="read-only"):
        gait_margins(plan)[0].contacts["pivot"].friction[0] = 1.0
