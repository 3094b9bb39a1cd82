"""Closed loop in short: the lift alone, under the hybrid law."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.control import Measurement, Reference
from pivotgait.exceptions import InputError, PlanFileError
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import (
    Perturbation,
    RunOptions,
    RunSeries,
    SimulatorOptions,
    World,
    judge,
    run,
)
from pivotgait.validation.closing import closing_distances
from pivotgait.validation.grasp import GRASP, standing_off, with_grasp
from pivotgait.validation.planned import planned_at
from pivotgait.validation.real_tool import real_tool

SHORT = RunOptions(grasp_s=0.3, hold_s=0.05)


@pytest.fixture(scope="module")
def lift(plan: GaitPlan) -> GaitPlan:
    return replace(plan, phases=plan.phases[:1])


@pytest.fixture(scope="module")
def series(lift: GaitPlan, scene: Scene) -> RunSeries:
    return run(lift, scene, Perturbation.none(scene.robot), SHORT)[0]


def test_the_lift_succeeds(lift: GaitPlan, scene: Scene, series: RunSeries) -> None:
    found = judge(lift, scene.robot, series, planned_at(lift, series.time, series.fingers))
    assert found.passed, found
    assert len(series.time) == round((1.5 + 0.3 + 0.05) / 1e-3)
    assert series.time[0] == pytest.approx(-0.3)


def test_same_seed_same_series(lift: GaitPlan, scene: Scene, series: RunSeries) -> None:
    again = run(lift, scene, Perturbation.none(scene.robot), SHORT)[0]
    for field in fields(series):
        one, two = getattr(series, field.name), getattr(again, field.name)
        if isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, two)


class Broken:
    """A control law that fails at half a second."""

    def __init__(self, torque: float) -> None:
        self.given = torque

    def reset(self) -> None:
        pass

    def torque(self, measurement: Measurement) -> np.ndarray:
        return np.full(19, self.given if measurement.time > 0.05 else 0.0)


@pytest.mark.parametrize("torque", [np.nan, np.inf])
def test_a_controller_gone_mad_is_a_divergence(lift: GaitPlan, scene: Scene, torque: float) -> None:
    def make(_: Reference) -> Broken:
        return Broken(torque)

    none = Perturbation.none(scene.robot)
    series, _ = run(lift, scene, none, replace(SHORT, grasp_s=0.02), controller=make)
    assert "not finite" in series.diverged
    assert np.isfinite(series.tau).all()
    found = judge(lift, scene.robot, series, planned_at(lift, series.time, series.fingers))
    assert not found.passed


def test_the_grasp_joins_the_plan(plan: GaitPlan, scene: Scene) -> None:
    longer = with_grasp(plan, scene.robot, 0.8)
    grasp, first = longer.phases[0], plan.phases[0]
    assert grasp.name == GRASP
    assert grasp.duration_s == pytest.approx(0.8)
    for name, track in grasp.contacts.items():
        np.testing.assert_array_equal(track.force[0], 0.0)
        np.testing.assert_array_equal(track.force[-1], first.contacts[name].force[0])
    np.testing.assert_allclose(grasp.robot.tau[-1], first.robot.tau[0], atol=1e-12)
    np.testing.assert_array_equal(grasp.robot.q[-1], first.robot.q[0])


@pytest.mark.parametrize("distance", [0.0, 0.003])
def test_fingertips_stand_off(plan: GaitPlan, scene: Scene, distance: float) -> None:
    robot, first = scene.robot, plan.phases[0]
    data = robot.model.createData()

    def tips(q: np.ndarray) -> dict[str, np.ndarray]:
        pin.framesForwardKinematics(robot.model, data, q)
        return {n: data.oMf[f.tip_frame_id].translation.copy() for n, f in robot.fingers.items()}

    distances = {"thumb": distance, "index": distance}
    before, after = tips(np.array(first.robot.q[0])), tips(standing_off(plan, robot, distances))
    turn = first.tool.rotation[0].as_matrix()
    for name in robot.fingers:
        track = first.contacts.get(name)
        way = np.zeros(3) if track is None else -distance * turn @ track.normal
        np.testing.assert_allclose(after[name] - before[name], way, atol=1e-6)


@pytest.mark.parametrize("offset", [-1e-3, 0.0, 1.5e-3])
@pytest.mark.parametrize("growth", [0.0, 1e-3])
def test_fingers_close_until_they_nearly_touch(
    plan: GaitPlan, scene: Scene, offset: float, growth: float
) -> None:
    """The knife's narrow sides look along world y: one finger stops earlier, the other later."""
    none, gap = Perturbation.none(scene.robot), 2e-4
    draw = replace(none, offset=np.array([0.0, offset, 0.0]), handle_growth=growth)
    real = real_tool(plan, scene, draw)
    found = closing_distances(plan, scene.robot, real, gap)
    turn = plan.phases[0].tool.rotation[0].as_matrix()
    for name, away in found.items():
        outward = -(turn @ plan.phases[0].contacts[name].normal)
        wanted = gap + 0.5 * growth + offset * outward[1]
        assert away == pytest.approx(wanted, abs=5e-5)


@pytest.mark.parametrize(
    ("step", "cycle", "steps"), [(2e-3, 2e-3, 1), (1e-3, 1e-3, 1), (2.5e-4, 1e-3, 4)]
)
def test_cycles_are_whole_steps(step: float, cycle: float, steps: int) -> None:
    options = RunOptions(engine=SimulatorOptions(step_s=step))
    assert options.steps_per_cycle == steps
    assert options.cycle_s == pytest.approx(cycle)


def test_a_step_that_does_not_divide_the_cycle_is_refused() -> None:
    with pytest.raises(InputError, match="no multiple"):
        _ = RunOptions(engine=SimulatorOptions(step_s=3e-4)).cycle_s


def test_the_world_is_the_plans(plan: GaitPlan) -> None:
    world = World.of(plan)
    assert world.finger_friction == dict.fromkeys(plan.robot.fingers, 0.8)
    assert world.table_friction == 0.4
    assert world.tip_radius == 0.001
    with pytest.raises(PlanFileError, match="no motion of a robot"):
        World.of(replace(plan, robot=None))
