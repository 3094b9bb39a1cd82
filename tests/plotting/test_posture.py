"""Forward kinematics against Pinocchio, and which link belongs to which part."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import PlanFileError, UnknownNameError
from pivotgait.plans.plan import PlannedFinger
from pivotgait.plotting.posture import ARM, HAND, skeleton


@pytest.fixture(scope="module")
def body(robot_plan):
    return skeleton(robot_plan.robot)


@pytest.fixture(scope="module")
def postures(robot_plan):
    model = pin.buildModelFromXML(robot_plan.robot.urdf)
    rng = np.random.default_rng(0)
    return rng.uniform(model.lowerPositionLimit, model.upperPositionLimit, (5, model.nq))


@pytest.mark.parametrize("backwards", [False, True])
def test_links_are_where_pinocchio_has_them(robot_plan, postures, backwards):
    robot = robot_plan.robot
    model = pin.buildModelFromXML(robot.urdf)
    order = list(model.names[1:])[:: -1 if backwards else 1]
    column = [list(model.names[1:]).index(name) for name in order]
    poses = skeleton(replace(robot, joint_names=tuple(order))).poses(postures[:, column])
    data = model.createData()
    for k, q in enumerate(postures):
        pin.framesForwardKinematics(model, data, q)
        for name, pose in poses.items():
            wanted = data.oMf[model.getFrameId(name, pin.FrameType.BODY)].homogeneous
            np.testing.assert_allclose(pose[k], wanted, atol=1e-12)


def test_every_link_belongs_to_one_part(body):
    assert set(body.parts) == set(body.urdf.links)
    assert body.palm == "palm"
    assert body.parts["palm"] == body.parts["rfdistal"] == HAND
    assert body.parts["forearm"] == body.parts["pedestal"] == ARM
    assert body.parts["thtip"] == body.parts["thbase"] == "thumb"
    assert {body.parts[tip] for tip in body.tips} == {"thumb", "index", "middle"}


def test_every_joint_belongs_to_one_group(body):
    groups = [body.joints_of(name) for name in ("arm", "thumb", "index", "middle")]
    assert sorted(sum(groups, ())) == sorted(body.joint_names)
    assert body.joints_of("index") == ("FFJ4", "FFJ3", "FFJ2", "FFJ1")
    assert body.joints_of("arm") == ("J1", "J2", "J3", "J4", "WRJ2", "WRJ1")


def test_a_single_finger_still_has_a_palm(robot_plan):
    robot = robot_plan.robot
    alone = replace(robot, fingers={"index": robot.fingers["index"]})
    body = skeleton(alone)
    assert body.parts["fftip"] == "index"
    assert body.parts[body.palm] == HAND


def test_an_unknown_tip_lists_the_known(robot_plan):
    wrong = replace(robot_plan.robot, fingers={"index": PlannedFinger("fftop", 0.006)})
    with pytest.raises(UnknownNameError, match="fftip"):
        skeleton(wrong)


@pytest.mark.parametrize("change", [lambda names: names[1:], lambda names: (*names, "J9")])
def test_joints_that_are_not_the_urdfs_are_refused(robot_plan, change):
    robot = robot_plan.robot
    with pytest.raises(PlanFileError, match="J"):
        skeleton(replace(robot, joint_names=change(robot.joint_names)))
