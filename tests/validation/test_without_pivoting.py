"""What is left of a removal when the tool may not turn; ways to carry a plan out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pivotgait.exceptions import InputError
from pivotgait.models import Scene
from pivotgait.plans import PIVOT, GaitPlan
from pivotgait.validation import BASELINES, RunOptions, TrialOptions, run_baselines
from pivotgait.validation.without_pivoting import friction_share, without_pivoting


@pytest.fixture(scope="module")
def still(plan: GaitPlan, scene: Scene) -> GaitPlan:
    return without_pivoting(plan, scene)


def test_the_gait_ends_with_the_removal_and_nothing_moves(plan: GaitPlan, still: GaitPlan) -> None:
    count = len(still.phases)
    removal, planned = still.phases[-1], plan.phases[count - 1]
    assert (removal.kind, planned.kind) == ("removal", "removal")
    assert still.phases[:-1] == plan.phases[: count - 1]
    assert np.ptp(removal.tool.orientation, axis=0).max() == 0.0
    assert removal.robot is not None
    assert np.ptp(removal.robot.q, axis=0).max() == 0.0
    np.testing.assert_array_equal(removal.robot.q[0], planned.robot.q[0])


def test_forces_balance_gravity_and_join(plan: GaitPlan, still: GaitPlan) -> None:
    removal, planned = still.phases[-1], plan.phases[len(still.phases) - 1]
    turn = removal.tool.rotation.as_matrix()
    total, moment = np.zeros((2, len(removal.time), 3))
    for name, track in removal.contacts.items():
        lever = turn @ (plan.tool.pivot_in_tool if name == PIVOT else track.point)
        total += track.force
        moment += np.cross(lever, track.force)
        np.testing.assert_allclose(track.force[0], planned.contacts[name].force[0], atol=1e-9)
    np.testing.assert_allclose(total, total[0] * np.ones((len(total), 1)), atol=1e-6)
    np.testing.assert_allclose(total[0] / np.linalg.norm(total[0]), [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(moment, 0.0, atol=1e-7)
    leaving = removal.contacts[removal.finger]
    np.testing.assert_allclose(leaving.force[-1], 0.0, atol=1e-9)
    ramp = [
        np.sum(p.contacts[p.finger].force * (p.tool.rotation.as_matrix() @ leaving.normal), 1)
        for p in (removal, planned)
    ]
    np.testing.assert_allclose(ramp[0], ramp[1], atol=1e-6)


def test_it_needs_more_friction_than_plans_may_use(
    plan: GaitPlan, still: GaitPlan, scene: Scene
) -> None:
    """Else there would be a plan without pivoting, and the planner would have found it."""
    usable = 1.0 - scene.allocation.friction_reserve
    assert friction_share(plan.phases[len(still.phases) - 1]).max() <= usable + 1e-6
    assert friction_share(still.phases[-1]).max() > usable


def test_a_plan_without_removal_is_refused(plan: GaitPlan, scene: Scene) -> None:
    with pytest.raises(InputError, match="no removal"):
        without_pivoting(replace(plan, phases=plan.phases[:3]), scene)


def test_baselines_differ_in_controller_and_pivoting_alone() -> None:
    options = TrialOptions(RunOptions(hold_s=0.3), plan_as_laid=False)
    ways = [each.of(options) for each in BASELINES]
    assert len({(way.run.controller, way.pivoting) for way in ways}) == len(BASELINES)
    assert ways[0] == options
    for way in ways:
        controller, pivoting = options.run.controller, options.pivoting
        same = replace(way, run=replace(way.run, controller=controller), pivoting=pivoting)
        assert same == options


@pytest.mark.slow
def test_the_command_compares(plan: GaitPlan, tmp_path: Path) -> None:
    from pivotgait.cli import main
    from pivotgait.plans import write_plan
    from pivotgait.reporting.summary import read_summary

    path, output = tmp_path / "plan.h5", tmp_path / "summary.json"
    write_plan(plan, path)
    output.write_text(json.dumps({"kept": 1}))
    with pytest.raises(SystemExit) as caught:
        main(["baselines", str(path), "-o", str(output)])
    assert caught.value.code == 0
    assert json.loads(output.read_text())["kept"] == 1
    found = read_summary(output).validations
    assert [each.pivoting for each in found] == [each.pivoting for each in BASELINES]
    assert found[0].passed == 1
    assert found[-1].stages[-2].name.endswith("removal")


def test_an_unknown_plan_is_refused(plan: GaitPlan) -> None:
    with pytest.raises(InputError, match="no seeds"):
        run_baselines(plan, [])
