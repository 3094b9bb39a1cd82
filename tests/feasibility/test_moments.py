"""Moments of a phase as grasps, with and without the joints' torque limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InfeasibleError
from pivotgait.feasibility import (
    Variants,
    VerdictOptions,
    judge,
    rehearse,
    robust_margins,
    static_verdicts,
    tool_length,
    wrench_ball,
)
from pivotgait.feasibility.moments import moments_of
from pivotgait.forces import LinearRows
from pivotgait.models import load_scene
from pivotgait.phases.grasp import Setting
from pivotgait.plans import RobotMotion

SCENE = load_scene("knife")
BODY = Setting.of(SCENE).body
PHASES = rehearse(SCENE, SCENE.gaits["default"]).phases
LENGTH = tool_length(SCENE.tool.pivot_in_tool)


@pytest.mark.parametrize("phase", PHASES, ids=lambda phase: phase.name)
def test_every_moment_of_a_feasible_phase_is_held(phase):
    some = moments_of(phase, BODY)
    assert some.grasps.names[0] == "pivot"
    assert some.time_s[-1] == pytest.approx(phase.duration_s)
    assert static_verdicts(some.grasps).feasible.all()
    # the forces found for the phase apply the wrench that the moment asks for
    at = np.searchsorted(phase.time, some.time_s - 1e-9)
    total = sum(track.force[at] for track in phase.contacts.values())
    assert np.allclose(total, some.grasps.problem.wrench[:, :3], atol=1e-7)
    changing = some.grasps.problem.fixed
    ramps = phase.kind in ("removal", "addition")
    assert np.isnan(changing).all() != ramps


def test_torque_limits_become_rows_that_bind_when_joints_are_weak():
    robot, phase = SCENE.robot, PHASES[0]
    still = np.zeros((len(phase.time), robot.nv))
    q = np.tile(pin.neutral(robot.model), (len(phase.time), 1))
    moving = replace(phase, robot=RobotMotion(q=q, v=still, a=still, tau=still))
    free = moments_of(phase, BODY, robot)
    assert not free.torque_limits
    radii = []
    for share in (1e3, 0.17):  # with less than 0.15 the hand cannot hold the knife at all
        strong = replace(robot, effort_max=share * robot.effort_max)
        some = moments_of(moving, BODY, strong)
        assert some.torque_limits
        last = some.grasps.take(np.array([some.grasps.count - 1]))
        radii.append(wrench_ball(last, LENGTH).radius_N)
    last_limited = last
    last = free.grasps.take(np.array([free.grasps.count - 1]))
    assert radii[0] == pytest.approx(wrench_ball(last, LENGTH).radius_N, rel=5e-3)
    assert radii[1] < 0.95 * radii[0]
    drop = robust_margins(last_limited).torque_drop[0]
    rows = last_limited.problem.rows
    assert rows.count >= 8  # every joint that feels a finger
    middle, half = 0.5 * (rows.lower + rows.upper), 0.5 * (rows.upper - rows.lower)
    assert 0.0 < drop < 1.0
    for nudge, good in ((1.005, True), (0.995, False)):
        width = nudge * (1.0 - drop) * half
        weaker = LinearRows(rows.matrix, middle - width, middle + width)
        assert static_verdicts(last_limited.changed(rows=weaker)).feasible[0] == good


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        ("needs 130 % of the torque of FFJ3", "torque"),
        pytest.param("no posture was found", "hand", marks=pytest.mark.slow),
    ],
)
def test_a_hand_that_cannot_do_it_makes_the_gait_infeasible(monkeypatch, words, kind):
    def refuse(*_args, **_options):
        raise InfeasibleError(words, where="03_removal", mend="choose other contacts")

    # this one first: it is loaded here, and must not take the other name's refusal for its own
    monkeypatch.setattr("pivotgait.feasibility.torque_mends.plan_gait", refuse)
    monkeypatch.setattr("pivotgait.gaits.plan_gait", refuse)
    found = judge(Variants(SCENE), VerdictOptions(hand=True, volume=False))
    assert not found.feasible
    assert (found.binding.kind, found.binding.phase) == (kind, "03_removal")
    assert words in found.binding.text
    assert found.margins.robust
