"""A run with recovery: phases done late are done; a finger put back for good is no success."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.control import (
    AdmittanceController,
    HybridController,
    RecoveringController,
    RecoveryEvent,
    RecoveryOptions,
    Reference,
)
from pivotgait.exceptions import InputError
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import RunSeries
from pivotgait.validation.guarding import guarded, most_cycles
from pivotgait.validation.planned import planned_at
from pivotgait.validation.verdict import Verdict, judge


def verdict(plan: GaitPlan, scene: Scene, series: RunSeries) -> Verdict:
    return judge(plan, scene.robot, series, planned_at(plan, series.followed, series.fingers))


def test_phases_done_late_count_as_done(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> None:
    late = np.where(faithful.time > 3.0, 0.7, 0.0)
    series = replace(faithful, time=faithful.time + late, plan_time=faithful.time)
    assert verdict(plan, scene, series).passed


def test_a_run_that_ends_in_the_grasp_before_a_removal_is_put_back(
    plan: GaitPlan, scene: Scene, faithful: RunSeries
) -> None:
    place = next(k for k, phase in enumerate(plan.phases) if phase.kind == "removal")
    start = sum(phase.duration_s for phase in plan.phases[:place])
    count = int(np.searchsorted(faithful.time, start + 0.1))
    series = faithful.first(count)
    event = RecoveryEvent("give up", "thumb", float(series.time[-1]), 0.1)
    series = replace(series, plan_time=series.time, recovery=(event,))
    found = verdict(plan, scene, series)
    assert (found.passed, found.failure) == (False, "put-back")
    assert found.stage == plan.phases[place].name
    assert found.time_s == event.time_s


def test_only_laws_with_planned_forces_can_be_guarded(plan: GaitPlan, scene: Scene) -> None:
    reference = Reference.of(plan, scene.robot)
    law = HybridController(reference)
    assert guarded(law, None) is law
    assert most_cycles(law, 100) == 100
    guard = guarded(law, RecoveryOptions())
    assert isinstance(guard, RecoveringController)
    assert most_cycles(guard, 100) > 100
    with pytest.raises(InputError, match="does not recover"):
        guarded(AdmittanceController(reference), RecoveryOptions())
