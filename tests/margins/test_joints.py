"""Shares of joint limits: exact at the limits, and the largest found where it is."""

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pivotgait.margins import SHARE_KINDS, joint_shares, largest_share
from pivotgait.plans.plan import (
    GaitPlan,
    Phase,
    PlannedFinger,
    PlannedRobot,
    PlannedTool,
    RobotMotion,
    ToolMotion,
)

_INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
URDF = f"""<robot name="two" version="1.1">
<link name="base"/>
<link name="slide">{_INERTIAL}</link>
<link name="tip">{_INERTIAL}</link>
<joint name="S" type="prismatic"><parent link="base"/><child link="slide"/><axis xyz="0 0 1"/>
<limit lower="0.1" upper="0.5" effort="20" velocity="0.5"/></joint>
<joint name="R" type="revolute"><parent link="slide"/><child link="tip"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="2" effort="4" velocity="3"/></joint>
</robot>"""
LIMITS = {
    "q": ((0.5, 2.0), (0.1, -1.0)),
    "v": ((0.5, 3.0), (-0.5, -3.0)),
    "tau": ((20, 4), (-20, -4)),
}
KINDS = dict(zip(("q", "v", "tau"), SHARE_KINDS, strict=True))


def gait(count: int = 4) -> GaitPlan:
    still = ToolMotion(
        np.zeros((count, 3)), np.tile(Rotation.identity().as_quat(), (count, 1)),
        *(np.zeros((count, 3)) for _ in range(4)),
    )  # fmt: skip
    rest = RobotMotion(np.tile((0.3, 0.5), (count, 1)), *(np.zeros((count, 2)) for _ in range(3)))
    phases = tuple(
        Phase(f"{k:02d}_lift", "lift", "", np.linspace(0.0, 1.0, count), still, {}, rest)
        for k in range(2)
    )
    tool = PlannedTool("t", 1.0, np.eye(3), np.zeros(3), "", np.zeros(3))
    robot = PlannedRobot(URDF, ("S", "R"), MappingProxyType({"f": PlannedFinger("tip", 0.01)}))
    return GaitPlan("", 0, {}, np.zeros(3), 0.0, tool, phases, robot)


def changed(plan: GaitPlan, number: int, **motion: np.ndarray) -> GaitPlan:
    phases = list(plan.phases)
    robot = phases[number].robot
    assert robot is not None
    phases[number] = replace(phases[number], robot=replace(robot, **motion))
    return replace(plan, phases=tuple(phases))


@pytest.mark.parametrize("quantity", LIMITS)
def test_shares_are_one_at_the_limits(quantity: str) -> None:
    for sign, limit in zip((1.0, -1.0), LIMITS[quantity], strict=True):
        plan = changed(gait(), 0, **{quantity: np.tile(limit, (4, 1))})
        found = joint_shares(plan)[0].of(KINDS[quantity])
        np.testing.assert_allclose(found, np.full((4, 2), sign))


@pytest.mark.parametrize("kind", SHARE_KINDS)
def test_shares_are_zero_in_the_middle_at_rest(kind) -> None:
    for shares in joint_shares(gait()):
        np.testing.assert_allclose(shares.of(kind), 0.0, atol=1e-15)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_largest_is_found_where_it_is(sign: float) -> None:
    tau = np.zeros((4, 2))
    tau[2, 1] = sign * 3.0
    plan = changed(gait(), 1, tau=tau)
    found = largest_share(plan, "torque")
    assert found is not None
    assert (found.joint, found.phase, found.value) == ("R", "01_lift", 0.75)
    assert found.time_s == pytest.approx(2 / 3)
    first = largest_share(plan, "torque", phase="00_lift")
    assert first is not None
    assert first.value == 0.0


def test_without_a_robot_there_are_none() -> None:
    plan = replace(gait(), robot=None)
    assert joint_shares(plan) == ()
    assert largest_share(plan, "speed") is None
