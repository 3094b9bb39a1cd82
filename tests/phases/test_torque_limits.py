"""Rows of joint torques mean torques, and say which joints they are about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pivotgait.models import Robot
from pivotgait.phases.torque_limits import torque_rows, torque_share
from pivotgait.phases.tracking import inverse_dynamics, with_torques
from pivotgait.plans import PIVOT
from tests.phases.hand_cases import lift, phase, robot, tracked

FINGERS = tuple(lift().after.fingers.values())


def weak(share: float) -> Robot:
    return replace(robot(), effort_max=share * robot().effort_max)


@pytest.mark.parametrize("share", [1e-3, 0.02, 0.3])
@pytest.mark.parametrize("reserve", [0.0, 0.15])
def test_rows_are_the_torques_between_their_limits(share: float, reserve: float) -> None:
    feeble, tool = weak(share), phase().tool
    rows = torque_rows(feeble, tracked(), tool, FINGERS, reserve=reserve)
    names = (PIVOT, *(each.finger for each in FINGERS))
    forces = np.concatenate([phase().contacts[name].force for name in names], axis=1)
    tau = with_torques(feeble, tracked(), phase().contacts, tool).tau
    free = inverse_dynamics(feeble, tracked())
    limit = (1.0 - reserve) * feeble.effort_max
    middle = -0.5 * (rows.lower + rows.upper)  # what the arm-hand needs by itself
    half = 0.5 * (rows.upper - rows.lower)
    kept = [int(np.argmin(np.abs(free - each[:, None]).max(axis=0))) for each in middle.T]
    assert len(set(kept)) == rows.count > 0
    np.testing.assert_allclose(middle, free[:, kept], atol=1e-12)
    np.testing.assert_allclose(half, np.tile(limit[kept], (len(half), 1)), rtol=1e-9)
    given = np.einsum("nij,nj->ni", rows.matrix, forces) + middle
    np.testing.assert_allclose(given, tau[:, kept], atol=1e-10)
    assert not rows.matrix[:, :, :3].any()  # the table's push moves no joint


def test_rows_left_out_cannot_bind() -> None:
    """Forces at the edge of their cones and at their largest pass no other joint's limit."""
    rng, tool = np.random.default_rng(0), phase().tool
    feeble = weak(0.3)
    some = torque_rows(feeble, tracked(), tool, FINGERS)
    every = torque_rows(weak(1e-9), tracked(), tool, FINGERS)  # all joints
    assert 0 < some.count < every.count == robot().nv
    limit = feeble.effort_max
    free = inverse_dynamics(feeble, tracked())
    chosen = {float(each) for each in some.upper[0]}
    left = [k for k in range(robot().nv) if float((limit - free)[0, k]) not in chosen]
    assert len(left) == every.count - some.count
    for _ in range(50):
        forces = [np.zeros((len(free), 3))]
        for finger in FINGERS:
            normal = phase().contacts[finger.finger].world_normal(tool)
            across = np.cross(normal, rng.normal(size=3))
            across /= np.linalg.norm(across, axis=1, keepdims=True)
            forces.append(finger.normal_max * (normal + finger.friction * across))
        pushed = np.einsum("nij,nj->ni", every.matrix, np.concatenate(forces, axis=1))
        assert np.all(np.abs(pushed + free)[:, left] <= limit[left])


def test_strong_joints_need_no_rows() -> None:
    assert torque_rows(weak(100.0), tracked(), phase().tool, FINGERS).count == 0


def test_share_names_the_worst_joint() -> None:
    tau = np.zeros((4, robot().nv))
    tau[2, 7] = -0.5 * robot().effort_max[7]
    tau[1, 3] = 0.4 * robot().effort_max[3]
    share, joint = torque_share(robot(), tau)
    assert share == pytest.approx(0.5)
    assert joint == robot().joint_names[7]
