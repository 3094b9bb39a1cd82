"""A control cycle against what Pinocchio itself needs for the same robot."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin

from pivotgait.benchmarks.relocation import knife_grip
from pivotgait.contacts import contact_frame
from pivotgait.control import HybridController, Measurement, Reference
from pivotgait.frozen import Array
from pivotgait.models import load_scene
from pivotgait.phases.timing import quintic
from pivotgait.phases.tracking import JointMotion, Waypoints, track, with_torques
from pivotgait.plans import (
    PIVOT,
    ContactTrack,
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    ToolMotion,
)

SAMPLES = 31
DURATION = 0.6  # [s]
ROLL = np.radians(8.0)  # by which the knife turns while three fingers hold it
IDLE_SWING = 0.15  # [rad], of the middle finger's joints while it is in the air
NORMAL, TANGENT = 3.0, 0.6  # [N], of each finger on the knife
MICROSECONDS = 1e-6


def held_knife_plan() -> GaitPlan:
    """The knife held by three fingers: it turns, then the middle finger leaves it.

    Made to exercise a controller, not to be carried out: the forces do not balance the weight.
    """
    grip, scene = knife_grip(), load_scene("knife")
    robot, tool = grip.world.robot, scene.tool
    time = np.linspace(0.0, DURATION, SAMPLES)
    turning = _turning(time, *grip.tool.pose(0.0))
    holds = tuple(grip.holds.values())
    motion = track(robot, holds, time, turning, Waypoints(np.array([0.0]), grip.q[None]))
    if np.ptp(motion.q) == 0.0:
        raise AssertionError
    return None  # type: ignore[return-value]
