"""The knife's lift with the hand that carries it out, and the torques of both."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from pivotgait.gaits.steps import Step, plan_steps
from pivotgait.kinematics import Hold
from pivotgait.models import Robot, Scene, load_scene
from pivotgait.phases.grasp import Setting
from pivotgait.phases.tracking import JointMotion, Waypoints, track
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_search import PostureSearch
from pivotgait.plans import Phase


@cache
def scene() -> Scene:
    """The built-in knife."""
    return load_scene("knife")


def robot() -> Robot:
    """The scene's."""
    found = scene().robot
    assert found is not None
    return found


@cache
def lift() -> Step:
    """The gait's first step, as the tool feels it."""
    return plan_steps(Setting.of(scene()), scene().gaits["default"][:1])[0]


def phase() -> Phase:
    """Of the lift."""
    found = lift().phase
    assert found is not None
    return found


@cache
def led() -> tuple[Sequence[Hold], Waypoints]:
    """Holds and postures at start, middle and end of the lift; collisions left out."""
    samples, turn = (0, 37, 75), phase().tool.rotation.as_matrix()
    fingers = lift().after.fingers
    keys = [KeyPose(f"{k}", turn[k], phase().tool.position[k], fingers) for k in samples]
    found = PostureSearch(robot(), None, keys, np.random.default_rng(5)).first()
    holds = [found.holds[finger, each.name] for finger, each in fingers.items()]
    return holds, Waypoints(np.array(samples), found.q)


@cache
def tracked() -> JointMotion:
    """The arm-hand's motion in the lift."""
    holds, through = led()
    return track(robot(), holds, phase().time, phase().tool, through)
