"""A faithful run passes with nothing to measure; each fault is found, named and dated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import Rule, RunSeries, Verdict, judge
from pivotgait.validation.margins import measured_margins, planned_margins
from pivotgait.validation.metrics import measure
from pivotgait.validation.planned import planned_at
from pivotgait.validation.verdict import FINAL_HOLD, stage_names


def verdict(plan: GaitPlan, scene: Scene, series: RunSeries) -> Verdict:
    return judge(plan, scene.robot, series, planned_at(plan, series.time, series.fingers))


def start_of(plan: GaitPlan, kind: str) -> float:
    place = next(k for k, phase in enumerate(plan.phases) if phase.kind == kind)
    return sum(phase.duration_s for phase in plan.phases[:place])


def turned(series: RunSeries, angle: np.ndarray) -> RunSeries:
    """The tool turned about its tip, around the world's x axis."""
    extra = Rotation.from_rotvec(angle[:, None] * [1.0, 0.0, 0.0])
    real = Rotation.from_quat(series.tool_orientation)
    before, after = real.as_matrix(), (extra * real).as_matrix()
    return replace(
        series,
        tool_position=series.tool_position + (before - after) @ series.pivot_in_tool,
        tool_orientation=(extra * real).as_quat(),
    )


def test_a_faithful_run_passes(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    assert verdict(plan, scene, faithful) == Verdict(passed=True)
    found = measure(scene.robot, faithful, planned_at(plan, faithful.time, faithful.fingers))
    assert found.holding_force_rms_N < 1e-9
    assert found.loading_force_rms_N < 1e-9
    assert found.orientation_deg < 1e-5
    assert found.tip_slip_mm < 1e-9
    # joints are straight between samples here, tips are not
    assert found.fingertip_slip_mm < 0.1
    assert 0.0 < found.torque_share <= 1.0


def test_margins_of_a_faithful_run_are_the_plans(plan: GaitPlan, faithful: RunSeries) -> None:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    for ours, theirs in zip(
        measured_margins(faithful, planned), planned_margins(planned), strict=True
    ):
        np.testing.assert_allclose(ours, theirs, atol=1e-9)
        assert theirs.min() > -1e-6


def test_every_contact_has_its_role(plan: GaitPlan, faithful: RunSeries) -> None:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    np.testing.assert_array_equal(planned.holds + planned.loads + planned.free, 1.0)
    np.testing.assert_array_equal(planned.force[planned.free > 0], 0.0)
    assert (planned.normal_force[planned.holds > 0] > 0.0).all()
    assert set(planned.phase) == set(range(len(plan.phases) + 1))


@pytest.mark.parametrize(
    ("seconds", "passes"), [(0.010, True), (0.018, True), (0.030, False), (0.2, False)]
)
@pytest.mark.parametrize("contact", ["thumb", "pivot"])
def test_lost_contacts(
    plan: GaitPlan, scene: Scene, faithful: RunSeries, contact: str, seconds: float, passes: bool
) -> None:
    begin = start_of(plan, "removal") + 0.3
    gone = (faithful.time >= begin) & (faithful.time <= begin + seconds)
    if contact == "pivot":
        series = replace(faithful, pivot_force=np.where(gone[:, None], 0.0, faithful.pivot_force))
    else:
        force = faithful.force.copy()
        force[gone, faithful.fingers.index(contact)] = 0.0
        series = replace(faithful, force=force)
    found = verdict(plan, scene, series)
    assert found.passed == passes
    if not passes:
        assert (found.failure, found.stage) == ("loss", "03_removal")
        assert found.time_s == pytest.approx(begin, abs=0.003)
        assert contact in found.detail


def test_a_finger_may_leave_when_it_is_removed(
    plan: GaitPlan, scene: Scene, faithful: RunSeries
) -> None:
    removal = next(phase for phase in plan.phases if phase.kind == "removal")
    place = faithful.fingers.index(removal.finger)
    force = faithful.force.copy()
    during = planned_at(plan, faithful.time, faithful.fingers).loads[:, place] > 0
    force[during, place] = 0.0
    assert verdict(plan, scene, replace(faithful, force=force)).passed


@pytest.mark.parametrize(("degrees", "passes"), [(4.9, True), (5.1, False)])
def test_roll_out(
    plan: GaitPlan, scene: Scene, faithful: RunSeries, degrees: float, passes: bool
) -> None:
    angle = np.where(faithful.time > 3.0, np.radians(degrees), 0.0)
    series = turned(faithful, angle)
    rule = Rule(fingertip_slip_m=1.0)  # fingers that stay behind slip, too
    found = judge(plan, scene.robot, series, planned_at(plan, series.time, series.fingers), rule)
    assert found.passed == passes
    if not passes:
        assert found.failure == "roll-out"
        assert found.time_s == pytest.approx(3.0, abs=0.003)


@pytest.mark.parametrize(("metres", "passes"), [(2.5e-3, True), (3.5e-3, False)])
def test_tip_slip_shows_the_stage(
    plan: GaitPlan, scene: Scene, faithful: RunSeries, metres: float, passes: bool
) -> None:
    late = faithful.time > sum(phase.duration_s for phase in plan.phases) + 0.1
    shift = np.where(late, metres, 0.0)[:, None] * [0.6, 0.0, 0.0]
    whole = replace(faithful, tool_position=faithful.tool_position + shift / 0.6)
    found = verdict(plan, scene, whole)
    assert found.passed == passes
    if not passes:
        assert (found.failure, found.stage) == ("slip", FINAL_HOLD)


def test_a_slip_before_the_plan_begins_does_not_count(
    plan: GaitPlan, scene: Scene, faithful: RunSeries
) -> None:
    shift = np.array([0.004, 0.0, 0.0]) * (faithful.time < 0.0)[:, None]
    series = replace(faithful, tool_position=faithful.tool_position + shift)
    assert verdict(plan, scene, series).passed


def test_limits(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    q, tau = faithful.q.copy(), faithful.tau.copy()
    q[600, 13] = scene.robot.upper[13] + 0.02  # the middle finger is still free
    found = verdict(plan, scene, replace(faithful, q=q))
    assert found.failure == "limit"
    tau[600:605, 8] = 1.1 * scene.robot.effort_max[8]
    assert verdict(plan, scene, replace(faithful, tau=tau)).passed
    tau[600:620, 8] = 1.1 * scene.robot.effort_max[8]
    found = verdict(plan, scene, replace(faithful, tau=tau))
    assert found.failure == "limit"
    assert faithful.joint_names[8] in found.detail


def test_touches(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    touching = replace(faithful, touches={"palm - tool": np.array([2.0])})
    found = verdict(plan, scene, touching)
    assert (found.failure, found.stage) == ("collision", "01_relocation")
    assert "palm - tool" in found.detail
    lying = replace(faithful, touching_table=np.array([-0.05, 0.0, 0.1]))
    assert verdict(plan, scene, lying).passed
    dropped = replace(faithful, touching_table=np.array([0.0, 1.4]))
    assert verdict(plan, scene, dropped).failure == "collision"


def test_a_free_finger_must_not_touch(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    force = faithful.force.copy()
    force[np.abs(faithful.time - 0.7) < 0.01, faithful.fingers.index("middle")] = 0.2
    found = verdict(plan, scene, replace(faithful, force=force))
    assert (found.failure, found.stage) == ("collision", "00_lift")


@pytest.mark.parametrize("touches", [True, False])
def test_a_gait_may_end_with_a_relocation(
    plan: GaitPlan, scene: Scene, faithful: RunSeries, touches: bool
) -> None:
    """The finger stands at its contact then, where it may touch or nearly so."""
    phases = plan.phases[:2]
    assert phases[-1].kind == "relocation"
    short, end = replace(plan, phases=phases), sum(each.duration_s for each in phases)
    series = faithful.first(int(np.searchsorted(faithful.time, end + 1.0)))
    force = series.force.copy()
    finger = series.fingers.index(phases[-1].finger)
    force[:, finger] = 0.0
    force[series.time > end, finger] = 0.05 * touches
    pressing = replace(series, force=force)
    assert verdict(short, scene, pressing).passed
    force[np.abs(series.time - end + 0.35) < 0.01, finger] = 0.05
    assert verdict(short, scene, replace(series, force=force)).failure == "collision"


def test_the_first_failure_counts(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    series = replace(
        faithful, touches={"palm - tool": np.array([2.0])}, diverged="a joint is not finite"
    )
    assert verdict(plan, scene, series).failure == "collision"
    broken = replace(faithful, diverged="a joint is not finite")
    found = verdict(plan, scene, broken)
    assert (found.failure, found.stage) == ("divergence", FINAL_HOLD)


def test_stages_are_phases_and_hold(plan: GaitPlan) -> None:
    assert stage_names(plan) == (*(phase.name for phase in plan.phases), FINAL_HOLD)
