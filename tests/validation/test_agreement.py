"""Laws of the comparison: a run agrees with itself, and known differences are found as they are."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InputError
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import CarriedOut, RunSeries, Tolerances, Verdict, compare_runs
from pivotgait.validation.agreement import Agreement
from pivotgait.validation.planned import planned_at

PASSED = Verdict(True)


@pytest.fixture
def compare(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> Any:
    """Compare the faithful run with another."""

    def with_other(other: RunSeries, *verdicts: Verdict, swap: bool = False) -> Agreement:
        said = verdicts or (PASSED, PASSED)
        pair = CarriedOut("one", faithful, said[0]), CarriedOut("two", other, said[1])
        return compare_runs(plan, scene.robot, *(pair[::-1] if swap else pair))

    return with_other


def changing(plan: GaitPlan, kind: str) -> tuple[str, str, float, float]:
    """Name, finger, start and end [s] of the first phase of a kind."""
    start = 0.0
    for phase in plan.phases:
        if phase.kind == kind:
            return phase.name, phase.finger, start, start + phase.duration_s
        start += phase.duration_s
    raise AssertionError(kind)


def test_a_run_agrees_with_itself(compare: Any, plan: GaitPlan, faithful: RunSeries) -> None:
    found = compare(faithful)
    assert found.agrees
    assert found.share_within == 1.0
    assert found.gap.ratio == 0.0
    assert [each.name for each in found.phases] == [*(p.name for p in plan.phases), "final_hold"]
    assert {each.verdicts for each in found.phases} == {("passed", "passed")}


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize(("moved_mm", "share"), [(0.9, 1.0), (1.1, 0.0)])
def test_a_moved_tool_is_that_far_away(
    compare: Any, faithful: RunSeries, moved_mm: float, share: float, swap: bool
) -> None:
    up = np.array([0.0, 0.0, 1e-3 * moved_mm])
    found = compare(replace(faithful, tool_position=faithful.tool_position + up), swap=swap)
    for phase in found.phases:
        assert phase.position_mm == pytest.approx(moved_mm)
        assert phase.orientation_deg == pytest.approx(0.0, abs=1e-5)
    assert found.gap.quantity == "position_mm"
    assert found.gap.ratio == pytest.approx(moved_mm)
    assert found.share_within == share
    assert found.agrees == (share == 1.0)


def test_a_turned_tool_is_that_far_turned(compare: Any, faithful: RunSeries) -> None:
    turn = Rotation.from_euler("z", 0.7, degrees=True)
    turned = (turn * Rotation.from_quat(faithful.tool_orientation)).as_quat()
    found = compare(replace(faithful, tool_orientation=turned))
    assert all(each.orientation_deg == pytest.approx(0.7, abs=1e-6) for each in found.phases)


def test_a_harder_press_is_that_many_newtons(
    compare: Any, plan: GaitPlan, faithful: RunSeries
) -> None:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    turn = Rotation.from_quat(faithful.tool_orientation).as_matrix()
    thumb = faithful.fingers.index("thumb")
    force = faithful.force.copy()
    force[:, thumb] += 0.25 * np.einsum("nij,nj->ni", turn, planned.normal[:, thumb])
    found = compare(replace(faithful, force=force))
    for phase in found.phases:
        assert phase.normal_force_rms_N["thumb"] == pytest.approx(0.25)
        others = [v for name, v in phase.normal_force_rms_N.items() if name != "thumb"]
        assert np.allclose(others, 0.0, atol=1e-12)
    assert (found.gap.quantity, found.gap.part) == ("normal_force_N", "thumb")
    assert found.gap.ratio == pytest.approx(2.5)
    assert found.share_within == 0.0


@pytest.mark.parametrize(("kind", "sign"), [("addition", 1.0), ("removal", -1.0)])
def test_a_contact_made_late_or_broken_early_is_timed(
    compare: Any, plan: GaitPlan, faithful: RunSeries, kind: str, sign: float
) -> None:
    name, finger, start, end = changing(plan, kind)
    apart_s, place = 0.1, faithful.fingers.index(finger)
    first = next(p for p in compare(faithful).phases if p.name == name).contact[0]
    assert start <= first.planned_s <= end
    assert first.actual_s == pytest.approx(first.planned_s, abs=1e-9)
    assert first.planned_rate_N_s > 0.5
    cut = first.actual_s + sign * apart_s
    quiet = (faithful.time >= start) & (faithful.time <= end)
    quiet &= (faithful.time < cut - 1e-6) if sign > 0 else (faithful.time > cut + 1e-6)
    force = faithful.force.copy()
    force[quiet, place] = 0.0
    found = next(p for p in compare(replace(faithful, force=force)).phases if p.name == name)
    assert found.contact[0].kind == {"addition": "make", "removal": "break"}[kind]
    assert found.timing_ms == pytest.approx(1e3 * apart_s, abs=2.1)


def test_a_contact_in_one_run_only_is_no_agreement(
    compare: Any, plan: GaitPlan, faithful: RunSeries
) -> None:
    name, finger, start, end = changing(plan, "addition")
    force = faithful.force.copy()
    inside = (faithful.time >= start) & (faithful.time <= end)
    force[inside, faithful.fingers.index(finger)] = 0.0
    found = compare(replace(faithful, force=force))
    assert np.isinf(found.gap.ratio)
    assert (found.gap.phase, found.gap.quantity) == (name, "timing_ms")
    assert not found.agrees
    text = json.dumps(found.as_json(), allow_nan=False)
    assert json.loads(text)["largest_gap"]["ratio"] is None


def test_a_run_that_ended_early_is_compared_to_its_end(
    compare: Any, plan: GaitPlan, faithful: RunSeries
) -> None:
    name, _, start, end = changing(plan, "removal")
    count = int(np.searchsorted(faithful.time, 0.5 * (start + end)))
    failed = Verdict(False, "slip", name, 0.5 * (start + end), "thumb slipped")
    found = compare(faithful.first(count), PASSED, failed)
    assert found.phases[-1].name == name
    assert found.phases[-1].verdicts == ("passed", "slip")
    assert found.phases[-1].contact is None
    assert found.phases[0].verdicts == ("passed", "passed")
    assert found.gap.ratio == 0.0
    assert not found.same_verdict
    assert not found.agrees


def test_looser_tolerances_never_lower_the_score(
    compare: Any, plan: GaitPlan, scene: Scene, faithful: RunSeries
) -> None:
    rng = np.random.default_rng(3)
    noisy = faithful.tool_position + 4e-4 * rng.normal(size=faithful.tool_position.shape)
    runs = [
        CarriedOut(name, each, PASSED)
        for name, each in (("one", faithful), ("two", replace(faithful, tool_position=noisy)))
    ]
    shares = []
    for mm in (0.2, 0.6, 1.0, 5.0):
        allowed = Tolerances(position_mm=mm, tip_slip_mm=9.0, fingertip_slip_mm=9.0)
        shares.append(compare_runs(plan, scene.robot, *runs, tolerances=allowed).share_within)
    assert shares == sorted(shares)
    assert shares[0] < 0.5
    assert shares[-1] == 1.0


def test_runs_of_other_cycles_are_refused(compare: Any, faithful: RunSeries) -> None:
    with pytest.raises(InputError, match="cycles"):
        compare(faithful.every(2))
    with pytest.raises(InputError, match="before the plan begins"):
        compare(faithful.first(3))


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_tolerances_are_refused(value: float) -> None:
    with pytest.raises(InputError, match="position_mm"):
        Tolerances(position_mm=value)
