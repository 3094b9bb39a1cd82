"""A small plan of every phase kind, with arbitrary numbers in the right places."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.plans import (
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    RobotMotion,
    ToolMotion,
)
from pivotgait.plans.plan import PHASE_KINDS


@pytest.fixture
def plan() -> GaitPlan:
    rng = np.random.default_rng(11)
    tool = PlannedTool(
        "rod", 0.2, np.diag([1e-4, 2e-4, 2e-4]), rng.normal(size=3), "<robot/>\n", np.zeros(3)
    )
    phases = tuple(_phase(rng, place, kind) for place, kind in enumerate(PHASE_KINDS))
    return GaitPlan(
        scene="tool: Messer für Gemüse\n",
        seed=2**40,
        versions={"pin": "4.1.0", "numpy": "2.4.6"},
        gravity=np.array([0.0, 0.0, -9.81]),
        table_height=0.7,
        tool=tool,
        phases=phases,
    )


@pytest.fixture
def robot_plan(plan: GaitPlan) -> GaitPlan:
    """The same with an arm-hand of four joints."""
    rng = np.random.default_rng(12)
    robot = PlannedRobot(
        urdf="<robot name='hand'/>\n",
        joint_names=("J1", "Gelenk_zwölf", "FFJ2", "FFJ1"),
        fingers={"thumb": PlannedFinger("thtip", 0.0075), "index": PlannedFinger("fftip", 0.006)},
        couplings=(("FFJ1", "FFJ2"),),
        never_touch=(("palm", "thtip"), ("arm", "palm")),
    )
    phases = tuple(
        replace(
            phase, robot=RobotMotion(*(rng.normal(size=(phase.time.size, 4)) for _ in range(4)))
        )
        for phase in plan.phases
    )
    return replace(plan, robot=robot, phases=phases)


def _phase(rng: np.random.Generator, place: int, kind: str) -> Phase:
    count = 3 + place
    motion = ToolMotion(
        rng.normal(size=(count, 3)),
        Rotation.random(count, rng=rng).as_quat(),
        *(rng.normal(size=(count, 3)) for _ in range(4)),
    )
    contacts = {
        name: ContactTrack(
            name, rng.normal(size=3), rng.normal(size=3), rng.normal(size=(count, 3)), 0.5, 0.1, 9.0
        )
        for name in ("pivot", "thumb", "index")
    }
    finger = "" if kind == "lift" else "index"
    time = np.concatenate(([0.0], np.cumsum(rng.uniform(0.1, 1.0, count - 1))))
    return Phase(f"{place:02d}_{kind}", kind, finger, time, motion, contacts)
