"""The closed loop in every engine: the lift passes, and a process of its own changes no bit."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_writer import plan_to_bytes
from pivotgait.validation import (
    Perturbation,
    RunOptions,
    SimulatorOptions,
    TrialOptions,
    TrialResult,
    judge,
    run,
    run_trial,
)
from pivotgait.validation.planned import planned_at
from pivotgait.validation.processes import run_jobs

SHORT = RunOptions(grasp_s=0.3, hold_s=0.05)


@pytest.fixture(scope="module")
def image(plan: GaitPlan) -> bytes:
    """The lift alone."""
    return plan_to_bytes(replace(plan, phases=plan.phases[:1]))


@pytest.fixture(scope="module")
def options(name: str) -> TrialOptions:
    """Not the defaults: they must travel to the other process."""
    engine = SimulatorOptions(contact_stiffness=1e4, contact_damping=80.0)
    return TrialOptions(replace(SHORT, simulator=name, engine=engine), plan_as_laid=False)


@pytest.fixture(scope="module")
def result(image: bytes, options: TrialOptions) -> TrialResult:
    return run_trial(image, None, 0, replace(options, perturbed=False))


def test_the_lift_passes(result: TrialResult) -> None:
    assert result.verdict.passed, result.verdict


def test_the_same_bits_in_another_process(
    image: bytes, options: TrialOptions, result: TrialResult
) -> None:
    given = (image, None, 0, replace(options, perturbed=False))
    (outcome,) = run_jobs(run_trial, [given], time_limit_s=60.0)
    assert outcome.value is not None, outcome.detail
    one, two = result.series, outcome.value.series
    for field in fields(one):
        mine, theirs = getattr(one, field.name), getattr(two, field.name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(mine, theirs)
        elif field.name != "touches":
            assert mine == theirs
    assert result.metrics == outcome.value.metrics


def test_contacts_travel_with_the_options(
    image: bytes, options: TrialOptions, result: TrialResult
) -> None:
    """A softer grip is another run: the option reached the engine."""
    softer = replace(options.run, engine=SimulatorOptions(contact_stiffness=5e3))
    other = run_trial(image, None, 0, TrialOptions(softer, perturbed=False))
    assert other.metrics != result.metrics


@pytest.mark.slow
@pytest.mark.parametrize("step", [1e-3, 2.5e-4])
def test_the_whole_gait_succeeds(plan: GaitPlan, scene: Scene, name: str, step: float) -> None:
    options = RunOptions(simulator=name, engine=SimulatorOptions(step_s=step))
    series, _ = run(plan, scene, Perturbation.none(scene.robot), options)
    found = judge(plan, scene.robot, series, planned_at(plan, series.time, series.fingers))
    assert found.passed, found
