"""The palm rows chosen make H square and keep it as far from singular as any choice can."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InfeasibleError, InputError
from pivotgait.kinematics import (
    ClosedChain,
    Hold,
    PalmRows,
    TaskJacobian,
    choose_palm_rows,
    smallest_singular_value,
)
from pivotgait.models import Robot
from pivotgait.models.robot_config import FingerConfig, RobotConfig
from pivotgait.models.robot_loading import build_robot

LENGTH = 0.03


def reference_matrix(task: TaskJacobian, palm: tuple[int, ...]) -> Any:
    """The scaled H of the arm-hand of the fixture, written out by hand."""
    chain = task.chain.jacobian.reshape(-1, 5, 19) * np.array([LENGTH] * 2 + [1.0] * 3)[:, None]
    rows = [chain.reshape(-1, 19)]
    holding = {hold.finger.name for hold in task.chain.holds}
    for name, finger in task.robot.fingers.items():
        if name not in holding:
            rows.append(LENGTH * np.eye(19)[list(finger.columns)])
    coordinates = task.palm.jacobian * np.array([LENGTH] * 3 + [1.0] * 3)[:, None]
    rows.append(coordinates[list(palm)])
    stacked = np.concatenate(rows)
    stacked[:, 2] *= LENGTH  # J3 slides
    return stacked


@pytest.mark.parametrize(("fingers", "palm_rows"), [(1, 6), (2, 5), (3, 4)])
def test_choice_is_the_best_of_all(grip: Any, fingers: int, palm_rows: int) -> None:
    task = TaskJacobian(grip.robot, grip.holds[:fingers], angle_length=LENGTH)
    choice = choose_palm_rows(task, grip.q, grip.oRtool, grip.position)
    assert len(choice.rows.coordinates) == len(choice.rows.names) == palm_rows
    task.update(grip.q, grip.oRtool, grip.position)
    every = {
        palm: np.linalg.svd(reference_matrix(task, palm), compute_uv=False)[-1]
        for palm in combinations(range(6), palm_rows)
    }
    assert choice.smallest_singular_value == pytest.approx(max(every.values()), rel=1e-9)
    assert every[choice.rows.coordinates] == pytest.approx(max(every.values()), rel=1e-9)
    assert smallest_singular_value(task, choice.rows) == pytest.approx(
        choice.smallest_singular_value, rel=1e-9
    )


def test_h_is_square_and_determines_the_joints(grip: Any) -> None:
    task = TaskJacobian(grip.robot, grip.holds)
    choice = choose_palm_rows(task, grip.q, grip.oRtool, grip.position)
    H, v = task.matrix(choice.rows), grip.rng.normal(size=grip.robot.nv)
    assert H.shape == (grip.robot.nv, grip.robot.nv)
    np.testing.assert_allclose(H[:15] @ v, task.chain.jacobian @ v, atol=1e-12)
    np.testing.assert_allclose(np.linalg.solve(H, H @ v), v, atol=1e-7)


def test_smallest_singular_value_is_the_distance_to_a_singular_matrix(grip: Any) -> None:
    task = TaskJacobian(grip.robot, grip.holds[:2])
    task.update(grip.q, grip.oRtool, grip.position)
    rows = task.candidates[0]
    H, distance = task.scaled_matrix(rows), smallest_singular_value(task, rows)
    left, _, right = np.linalg.svd(H)
    nearest = H - distance * np.outer(left[:, -1], right[-1])
    assert np.linalg.matrix_rank(nearest, tol=1e-12) == grip.robot.nv - 1
    assert np.linalg.norm(H - nearest) == pytest.approx(distance)


def test_choice_over_a_motion_has_the_best_worst_case(grip: Any) -> None:
    task = TaskJacobian(grip.robot, grip.holds)
    path = np.stack([grip.near(0.1) for _ in range(5)])
    turns, places = np.stack([grip.oRtool] * 5), np.stack([grip.position] * 5)
    choice = choose_palm_rows(task, path, turns, places)
    values = []
    for q in path:
        task.update(q, grip.oRtool, grip.position)
        values.append([smallest_singular_value(task, rows) for rows in task.candidates])
    worst = np.min(values, axis=0)
    assert choice.smallest_singular_value == pytest.approx(worst.max(), rel=1e-9)
    assert task.candidates[int(np.argmax(worst))] == choice.rows


def test_palm_angles_count_from_the_target(grip: Any) -> None:
    """From its own axes the palm's rows are the palm's twist in these axes, angles reversed."""
    robot, data = grip.robot, grip.robot.model.createData()
    pin.computeJointJacobians(robot.model, data, grip.q)
    placement = pin.updateFramePlacement(robot.model, data, robot.palm_frame_id)
    task = TaskJacobian(robot, grip.holds, palm_target=grip.oRtool.T @ placement.rotation)
    task.update(grip.q, grip.oRtool, grip.position)
    twist = pin.getFrameJacobian(robot.model, data, robot.palm_frame_id, pin.LOCAL)
    np.testing.assert_allclose(task.palm.value[:3], 0.0, atol=1e-14)
    np.testing.assert_allclose(task.palm.jacobian, twist[[5, 4, 3, 0, 1, 2]], atol=1e-14)


def test_finger_cannot_hold_twice(grip: Any) -> None:
    with pytest.raises(InputError, match="holds twice"):
        TaskJacobian(grip.robot, [grip.holds[0], grip.holds[0]])


@pytest.mark.parametrize("length", [0.0, -0.03, np.nan, np.inf])
def test_length_of_a_radian_is_positive(grip: Any, length: float) -> None:
    with pytest.raises(InputError, match="angle_length"):
        TaskJacobian(grip.robot, grip.holds, angle_length=length)


def chain_of_joints(
    prefix: str, parent: str, count: int, offset: float, first: str = "revolute"
) -> str:
    """URDF links and joints in a row, with axes x, y, z by turns, each 5 cm on."""
    text = []
    for k in range(count):
        axis = " ".join("1" if k % 3 == i else "0" for i in range(3))
        place = f"{offset if k == 0 else 0.01} 0.02 0.05"
        kind = first if k == 0 else "revolute"
        tip = '<collision><geometry><sphere radius="0.006"/></geometry></collision>'
        text.append(
            f'<link name="{prefix}{k}">{tip}<inertial><mass value="0.1"/>'
            f'<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>'
            f"</link>\n"
            f'<joint name="{prefix}j{k}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{prefix}{k}"/><origin xyz="{place}" rpy="0 0 0"/>'
            f'<axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>\n'
        )
        parent = f"{prefix}{k}"
    return "".join(text)


def simple_robot(arm: int, finger: int, base_joint: str = "revolute") -> Robot:
    """An arm that carries two equal fingers."""
    palm = f"a{arm - 1}"
    urdf = (
        '<robot name="simple" version="1.1">\n<link name="base"/>\n'
        + chain_of_joints("a", "base", arm, 0.0, base_joint)
        + chain_of_joints("f", palm, finger, 0.03)
        + chain_of_joints("g", palm, finger, -0.03)
        + "</robot>"
    )
    fingers = {
        name: FingerConfig(
            tip_frame=f"{name}{finger - 1}",
            tip_radius_m=0.006,
            pad=(0.0, 0.0, 1.0),
            joints=tuple(f"{name}j{k}" for k in range(finger)),
        )
        for name in ("f", "g")
    }
    return build_robot(urdf, RobotConfig(urdf="simple", palm=palm, fingers=fingers), where="robot")


def holds_at(robot: Robot, q: Any, *names: str) -> list[Hold]:
    origin, up = np.zeros(3), np.array([0.0, 0.0, 1.0])
    return [Hold.at(robot, q, np.eye(3), robot.fingers[name], origin, up) for name in names]


@pytest.mark.parametrize(
    ("arm", "finger", "palm_rows", "joint_rows"), [(6, 5, 6, 0), (8, 5, 6, 2), (6, 6, 6, 2)]
)
def test_redundant_joints_take_the_rows_beyond_six(
    arm: int, finger: int, palm_rows: int, joint_rows: int
) -> None:
    robot = simple_robot(arm, finger)
    q = np.random.default_rng(3).uniform(-0.8, 0.8, robot.nv)
    task = TaskJacobian(robot, holds_at(robot, q, "f", "g"))
    choice = choose_palm_rows(task, q, np.eye(3), np.zeros(3))
    assert len(choice.rows.coordinates) == palm_rows
    assert len(choice.rows.joints) == joint_rows
    assert choice.smallest_singular_value > 1e-5
    assert task.matrix(choice.rows).shape == (robot.nv, robot.nv)


def test_row_of_a_sliding_joint_is_scaled_like_any_joints() -> None:
    robot = simple_robot(8, 5, "prismatic")
    q = np.full(robot.nv, 0.3)
    task = TaskJacobian(robot, holds_at(robot, q, "f", "g"), angle_length=LENGTH)
    task.update(q, np.eye(3), np.zeros(3))
    H = task.scaled_matrix(PalmRows(tuple(range(6)), (0, 3)))
    np.testing.assert_allclose(H[-2:], LENGTH * np.eye(robot.nv)[[0, 3]], atol=1e-17)
    palm = task.palm.jacobian[3:, 0]
    np.testing.assert_allclose(H[13:16, 0], LENGTH * palm, atol=1e-17)


def test_too_few_joints_for_the_holds() -> None:
    robot = simple_robot(1, 2)
    holds = holds_at(robot, np.zeros(5), "f")
    assert ClosedChain(robot, holds).rows == 5
    with pytest.raises(InfeasibleError, match="only 5 joints"):
        TaskJacobian(robot, holds)


def test_names_of_the_rows() -> None:
    assert PalmRows((0, 2, 5)).names == ("theta", "phi", "z")
