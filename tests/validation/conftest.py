"""The knife's whole gait, and a run that follows it to the letter."""

from __future__ import annotations

import numpy as np
import pytest

from pivotgait.frozen import Array
from pivotgait.gaits import plan_gait
from pivotgait.models import Scene, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import RunSeries
from pivotgait.validation.planned import planned_at
from pivotgait.validation.simulator import SIMULATORS

PERIOD = 0.002
HOLD = 0.5


@pytest.fixture(scope="module", params=SIMULATORS)
def name(request: pytest.FixtureRequest) -> str:
    """Of each simulator that is installed."""
    engine = str(request.param)
    pytest.importorskip(engine)
    return engine


@pytest.fixture(scope="session")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(scope="session")
def plan(scene: Scene) -> GaitPlan:
    return plan_gait(scene)


@pytest.fixture(scope="session")
def faithful(plan: GaitPlan, scene: Scene) -> RunSeries:
    """What a perfect robot, tool and table would leave behind."""
    starts = np.concatenate(([0.0], np.cumsum([each.duration_s for each in plan.phases])))
    time = np.arange(-0.1, starts[-1] + HOLD, PERIOD)
    sampled = np.concatenate([s + p.time for s, p in zip(starts, plan.phases, strict=False)])

    def joined(name: str) -> Array:
        values = np.concatenate([getattr(p.robot, name) for p in plan.phases])
        columns = [np.interp(time, sampled, column) for column in values.T]
        return np.stack(columns, axis=1)

    fingers = tuple(scene.robot.fingers)
    planned = planned_at(plan, time, fingers)
    turn = planned.rotation.as_matrix()
    force = np.einsum("nij,nkj->nki", turn, planned.force)
    pivot = scene.pivot
    return RunSeries(
        fingers=fingers,
        joint_names=scene.robot.joint_names,
        time=time,
        q=joined("q"),
        v=joined("v"),
        tau=joined("tau"),
        tool_position=pivot - turn @ plan.tool.pivot_in_tool,
        tool_orientation=planned.orientation,
        force=force,
        reading=force,
        pivot_force=planned.pivot_force,
        touches={},
        touching_table=np.zeros(0),
        diverged="",
        pivot_in_tool=plan.tool.pivot_in_tool,
    )
