"""The hand through a gait: certified plans, the same each time, and refusals that say why."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from pivotgait.certification import certify
from pivotgait.exceptions import InfeasibleError
from pivotgait.gaits import PhaseDone, PosturesFound, plan_gait
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import RelocationPhase, Scene, export_scene, load_scene, parse_scene
from pivotgait.models.robot_loading import build_robot
from pivotgait.planning.posture_search import PostureOptions
from pivotgait.plans import GaitPlan

JOINT = "FFJ3"
SLOW = pytest.mark.slow  # another whole gait
SEEDS = {"knife": 1, "screwdriver": 0}
BOTH = pytest.mark.parametrize("name", ["knife", pytest.param("screwdriver", marks=SLOW)])


@cache
def planned(name: str) -> tuple[GaitPlan, tuple[PhaseDone | PosturesFound, ...]]:
    news: list[PhaseDone | PosturesFound] = []
    return plan_gait(load_scene(name), seed=SEEDS[name], progress=news.append), tuple(news)


def torque(plan: GaitPlan, joint: str) -> float:
    """Largest in the plan [N m]."""
    assert plan.robot is not None
    column = plan.robot.joint_names.index(joint)
    return max(float(np.abs(phase.robot.tau[:, column]).max()) for phase in plan.phases)


def knife(until: str) -> Scene:
    """The knife with its gait up to the first phase of a kind, without that."""
    text = export_scene("knife")
    return parse_scene(text[: text.index(f"    - {{kind: {until}")])


def weakened(scene: Scene, joint: str, effort: float) -> Scene:
    """The scene with another torque limit [N m] in its robot's URDF."""
    robot, config = scene.robot, scene.config.robot
    assert robot is not None
    assert config is not None
    pattern = rf'(<joint name="{joint}".*?effort=")[^"]*'
    text, count = re.subn(pattern, rf"\g<1>{effort:g}", robot.urdf, count=1, flags=re.DOTALL)
    assert count == 1
    return replace(scene, robot=build_robot(text, config, where="robot"))


@BOTH
def test_plan_certifies(name: str) -> None:
    certificate = certify(planned(name)[0])
    assert certificate.valid, [violation.as_json() for violation in certificate.violations]


@BOTH
def test_plan_follows_its_scene(name: str) -> None:
    plan, scene = planned(name)[0], load_scene(name)
    assert [phase.kind for phase in plan.phases] == [each.kind for each in scene.gaits["default"]]
    assert plan.robot is not None
    assert plan.robot.joint_names == scene.robot.joint_names
    assert plan.robot.fingers.keys() == scene.robot.fingers.keys()
    for phase, config in zip(plan.phases, scene.gaits["default"], strict=True):
        assert phase.robot is not None
        assert phase.robot.q.shape == (len(phase.time), scene.robot.nv)
        if isinstance(config, RelocationPhase):
            assert phase.record["solver"] == "RRT"
            assert phase.record["length_m"] > 0.0
        else:
            assert phase.duration_s == pytest.approx(config.duration_s)


@BOTH
def test_joints_join_from_phase_to_phase(name: str) -> None:
    phases = planned(name)[0].phases
    for before, after in pairwise(phases):
        np.testing.assert_allclose(before.robot.q[-1], after.robot.q[0], atol=1e-8)
        np.testing.assert_allclose(before.robot.tau[-1], after.robot.tau[0], atol=1e-5)


@BOTH
def test_progress_is_told(name: str) -> None:
    plan, (postures, *done) = planned(name)
    assert isinstance(postures, PosturesFound)
    assert postures.starts >= 1
    assert postures.search_time_s > 0.0
    assert [each.place for each in done] == list(range(len(plan.phases)))
    assert all(each.phase is phase for each, phase in zip(done, plan.phases, strict=True))
    assert all(each.plan_time_s > 0.0 for each in done)


def test_same_seed_same_motion() -> None:
    """To the last bit; another seed finds other postures."""
    begin = knife(until="removal")
    one, same = (plan_gait(begin, seed=4) for _ in range(2))
    for here, there in zip(one.phases, same.phases, strict=True):
        for name in ("q", "v", "a", "tau"):
            np.testing.assert_array_equal(getattr(here.robot, name), getattr(there.robot, name))
        np.testing.assert_array_equal(here.time, there.time)
    other = plan_gait(knife(until="relocation"), seed=5)
    assert not np.allclose(other.phases[0].robot.q[0], one.phases[0].robot.q[0], atol=1e-3)


def test_without_the_hand_there_is_no_robot() -> None:
    plan = plan_gait(knife(until="relocation"), hand=False)
    assert plan.robot is None
    assert all(phase.robot is None for phase in plan.phases)


def test_torques_are_those_under_the_scene_s_gravity() -> None:
    text = knife(until="relocation").yaml.replace("[0, 0, -9.81]", "[0.4, 0, -7.0]")
    plan = plan_gait(parse_scene(text))
    certificate = certify(plan)
    assert certificate.valid, [violation.as_json() for violation in certificate.violations]


def test_a_weaker_joint_is_spared() -> None:
    begin = knife(until="removal")
    limit = 0.8 * torque(plan_gait(begin, seed=1), JOINT)
    plan = plan_gait(weakened(begin, JOINT, limit), seed=1)
    assert 0.9 * limit < torque(plan, JOINT) <= limit
    certificate = certify(plan)
    assert certificate.valid, [violation.as_json() for violation in certificate.violations]


@SLOW
def test_a_weaker_joint_is_spared_in_a_whole_gait() -> None:
    limit = 0.8 * torque(planned("knife")[0], JOINT)
    plan = plan_gait(weakened(load_scene("knife"), JOINT, limit), seed=SEEDS["knife"])
    assert torque(plan, JOINT) <= limit
    certificate = certify(plan)
    assert certificate.valid, [violation.as_json() for violation in certificate.violations]


def test_a_joint_far_too_weak_is_named() -> None:
    scene = knife(until="relocation")
    limit = 0.2 * torque(plan_gait(scene), JOINT)
    with pytest.raises(InfeasibleError, match=r"^00_lift: within the torque limits") as caught:
        plan_gait(weakened(scene, JOINT, limit))
    assert f"00_lift takes 500 % of the torque of {JOINT}" in caught.value.what
    assert caught.value.mend


def test_a_tool_out_of_the_arm_s_reach() -> None:
    text = export_scene("knife").replace("pivot_m: [0.55,", "pivot_m: [3.55,")
    scene = parse_scene(text.replace("centre_m: [0.45,", "centre_m: [3.45,"))
    options = HandOptions(postures=PostureOptions(starts=5))
    with pytest.raises(InfeasibleError, match=r"^the hand's gait: no posture in 5 starts") as found:
        plan_gait(scene, options=options)
    contact, distance = re.search(r"starts: (\w+) stays ([\d.]+) mm off", found.value.what).groups()
    assert contact in scene.contacts
    assert 1500.0 < float(distance) < 4000.0


def test_a_joint_that_is_too_slow_is_named() -> None:
    """It refuses every posture that is found, so that it is the most frequent reason."""
    scene = knife(until="relocation")
    speed = np.array(scene.robot.velocity_max)
    speed[0] *= 1e-6
    slow = replace(scene, robot=replace(scene.robot, velocity_max=speed))
    options = HandOptions(postures=PostureOptions(starts=12))
    with pytest.raises(InfeasibleError, match="most often: 00_lift: is too fast for J1"):
        plan_gait(slow, seed=2, options=options)


@SLOW
def test_postures_that_a_scene_suggests_save_the_search() -> None:
    news: list[PhaseDone | PosturesFound] = []
    plan = plan_gait(load_scene("wrench_lift_off"), progress=news.append)
    (found,) = (each for each in news if isinstance(each, PosturesFound))
    assert found.starts == 0
    assert certify(plan).valid
