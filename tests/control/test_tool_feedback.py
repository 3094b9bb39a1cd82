"""The forces that turn the tool back: their moment, their size, their silence on the plan."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.control import HybridController, Measurement, Reference, ToolGains
from pivotgait.control.tool_feedback import ToolFeedback
from pivotgait.exceptions import InputError

Read = Callable[..., Measurement]
FREE = ToolGains(stiffness=3.0, damping=0.1, share=1e6)


@pytest.fixture(scope="module")
def law(reference: Reference) -> HybridController:
    return HybridController(reference)


def corrections(reference, law, reading, gains):
    wanted = reference.at(reading.time)
    feedback = ToolFeedback(gains, reference.plan.tool.pivot_in_tool)
    task = law.tasks[wanted.phase]
    return task, wanted, feedback.correction(task, wanted, reading)


def test_silent_on_the_plan(reference: Reference, law: HybridController, read: Read) -> None:
    _, _, force = corrections(reference, law, read(0.3), FREE)
    np.testing.assert_allclose(force, 0.0, atol=1e-12)


@pytest.mark.parametrize("axis", range(3))
def test_moment_turns_the_tool_back(
    reference: Reference, law: HybridController, read: Read, axis: int
) -> None:
    """Three fingers far from the pivot give the moment asked for, but for what damping takes."""
    plain = read(0.3)
    turn = pin.exp3(0.02 * np.eye(3)[axis])
    reading = plain._replace(tool_rotation=turn @ plain.tool_rotation)
    task, _, force = corrections(reference, law, reading, FREE)
    levers = task.contacts_in_tool - reference.plan.tool.pivot_in_tool
    moment = reading.tool_rotation @ np.cross(levers, force).sum(axis=0)
    asked = -3.0 * np.sin(0.02) * np.eye(3)[axis]
    assert moment @ asked > 0.3 * asked @ asked
    assert np.linalg.norm(moment) <= np.linalg.norm(asked) * (1.0 + 1e-9)


def test_a_turning_tool_is_slowed(reference: Reference, law: HybridController, read: Read) -> None:
    plain = read(0.3)
    extra = np.array([0.3, -0.2, 0.1])
    reading = plain._replace(tool_angular_velocity=plain.tool_angular_velocity + extra)
    task, _, force = corrections(reference, law, reading, FREE)
    levers = task.contacts_in_tool - reference.plan.tool.pivot_in_tool
    moment = reading.tool_rotation @ np.cross(levers, force).sum(axis=0)
    assert moment @ extra < 0.0


def test_size_is_limited(reference: Reference, law: HybridController, read: Read) -> None:
    plain = read(0.3)
    reading = plain._replace(tool_rotation=pin.exp3(np.array([0.0, 1.0, 0.0])) @ np.eye(3))
    gains = ToolGains(share=0.2)
    task, wanted, force = corrections(reference, law, reading, gains)
    planned = (wanted.force_in_tool * task.normals_in_tool).sum(axis=1)
    assert np.all(np.linalg.norm(force, axis=1) <= 0.2 * planned * (1.0 + 1e-9))
    assert np.max(np.linalg.norm(force, axis=1) / planned) == pytest.approx(0.2)


def test_without_it_the_pose_only_turns_forces(reference: Reference, read: Read) -> None:
    law = HybridController(reference, tool_gains=None)
    plain = read(0.3)
    moved = plain._replace(tool_position=plain.tool_position + 0.01)
    np.testing.assert_array_equal(law.torque(moved), law.torque(plain))


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_bad_gains_are_refused(value: float) -> None:
    with pytest.raises(InputError, match="stiffness"):
        ToolGains(stiffness=value)
