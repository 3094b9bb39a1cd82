"""A tool that is taken off the table: what the plan wants of it, and whether it comes true."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.plans import GaitPlan
from pivotgait.validation.perturbation import Perturbation
from pivotgait.validation.planned import Planned, planned_at
from pivotgait.validation.run import RunOptions, run
from pivotgait.validation.verdict import judge
from pivotgait.validation.world import World

FINGERS = ("thumb", "index", "middle")


@pytest.fixture(scope="module")
def plan() -> GaitPlan:
    return plan_gait(load_scene("screwdriver"), hand=False)


@pytest.fixture(scope="module")
def time(plan: GaitPlan) -> np.ndarray:
    return np.arange(0.003, sum(phase.duration_s for phase in plan.phases) + 0.5, 0.01)


@pytest.fixture(scope="module")
def planned(plan: GaitPlan, time: np.ndarray) -> Planned:
    return planned_at(plan, time, FINGERS)


def test_the_tool_is_carried_from_the_transfer_on(
    plan: GaitPlan, planned: Planned, time: np.ndarray
) -> None:
    start = sum(phase.duration_s for phase in plan.phases[:-1])
    np.testing.assert_array_equal(planned.carried, time > start)
    assert planned.rise[planned.carried == 0.0].max() == 0.0
    assert planned.rise[-1] == pytest.approx(0.05)
    assert np.all(np.diff(planned.rise) >= 0.0)


def test_the_table_is_as_far_below_as_the_tool_has_risen(planned: Planned) -> None:
    carried = planned.carried > 0.0
    low = planned.height[carried] - planned.rise[carried]
    np.testing.assert_allclose(low, low[0], atol=1e-9)
    np.testing.assert_allclose(planned.pivot_force[-1], 0.0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("simulator", ["pybullet", "mujoco"])
def test_the_screwdriver_hangs_at_its_height_to_the_end(simulator: str) -> None:
    pytest.importorskip(simulator)
    scene = load_scene("screwdriver")
    assert scene.robot is not None
    plan = plan_gait(scene, seed=0)
    assert set(World.of(plan).finger_torsion.values()) == {1e-3}
    series, _ = run(plan, scene, Perturbation.none(scene.robot, 0), RunOptions(simulator=simulator))
    wanted = planned_at(plan, series.time, series.fingers)
    verdict = judge(plan, scene.robot, series, wanted)
    assert verdict.passed, verdict
    start = int(np.argmax(wanted.carried))
    rise = series.tool_position[-1, 2] - series.tool_position[start, 2]
    assert rise == pytest.approx(0.05, abs=2e-3)
    np.testing.assert_array_equal(series.pivot_force[-1000:], 0.0)
