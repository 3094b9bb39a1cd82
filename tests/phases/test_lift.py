"""Lifts: from rest to the target with forces that carry the tool at every sample."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.spatial.transform import Rotation

from pivotgait.exceptions import InfeasibleError
from pivotgait.phases.grasp import Grasp
from pivotgait.phases.lift import LiftOptions, plan_lift
from pivotgait.phases.timing import Profile
from pivotgait.plans import Phase

Fixture = Callable[..., Any]
SCENES = pytest.mark.parametrize("name", ["knife", "screwdriver", "wrench"])
PROFILES = pytest.mark.parametrize("profile", ["quintic", "trapezoidal"])


def edit(profile: str) -> tuple[str, str]:
    return "profile: quintic", f"profile: {profile}"


@SCENES
@PROFILES
def test_lift_keeps_every_law(
    moment: Fixture, planned: Fixture, assert_laws: Fixture, name: str, profile: str
) -> None:
    phase, _ = planned(name, 0, edit(profile))
    assert_laws(moment(name, 0, edit(profile)), phase)
    assert phase.kind == "lift"
    assert phase.finger == ""
    assert set(phase.contacts) == {"pivot", "thumb", "index"}


@SCENES
@PROFILES
def test_lift_goes_from_rest_to_the_target(
    moment: Fixture, planned: Fixture, name: str, profile: str
) -> None:
    before = moment(name, 0, edit(profile))
    phase, after = planned(name, 0, edit(profile))
    scene = before.setting.scene
    target = scene.lift_rotation(before.config.to)
    ends = phase.tool.rotation[[0, -1]]
    # slerp is exact at its ends: rounding of a product of quaternions
    assert (scene.rest_rotation.inv() * ends[0]).magnitude() < 1e-14
    assert (target.inv() * ends[1]).magnitude() < 1e-14
    assert (target.inv() * after.rotation).magnitude() < 1e-14
    for finger in ("thumb", "index"):
        np.testing.assert_array_equal(after.forces[finger], phase.contacts[finger].force[-1])
        assert after.fingers[finger].finger == finger
    # the shortest way: never farther from the start than the whole turn
    turned = (scene.rest_rotation.inv() * phase.tool.rotation).magnitude()
    assert (np.diff(turned) > -1e-14).all()


@SCENES
def test_handle_rises_and_stays_over_the_table(
    moment: Fixture, planned: Fixture, name: str
) -> None:
    scene, (phase, _) = moment(name, 0).setting.scene, planned(name, 0)
    height = scene.height(phase.tool.rotation)
    assert height[0] == pytest.approx(0.0, abs=1e-9)  # it rests on the table
    assert height[-1] >= scene.clearance


@SCENES
def test_fingers_alone_do_the_work(moment: Fixture, planned: Fixture, name: str) -> None:
    (phase, _), body = planned(name, 0), moment(name, 0).setting.body
    motion, power = phase.tool, np.zeros(len(phase.time))
    for track in phase.contacts.values():
        lever = track.world_point(motion) - motion.position
        velocity = motion.linear_velocity + np.cross(motion.angular_velocity, lever)
        if not track.is_pivot:
            power += np.sum(track.force * velocity, axis=1)
    rise = motion.position[-1] - motion.position[0]
    # Simpson over 75 steps of a C2 motion that starts and ends at rest: 1e-5 of the work
    assert simpson(power, x=phase.time) == pytest.approx(-body.mass * body.gravity @ rise, rel=1e-5)


@SCENES
def test_quintic_lift_keeps_the_rate_of_force(moment: Fixture, planned: Fixture, name: str) -> None:
    phase, _ = planned(name, 0)
    assert largest_rate(phase) <= moment(name, 0).setting.scene.allocation.force_rate_max_N_s


def test_a_lift_too_fast_for_the_rate_says_so(moment: Fixture, planned: Fixture) -> None:
    # thumb and index finger of the wrench shall mirror each other: both must change as they do,
    # so that no allocation has a smaller largest rate
    facing = ("along_m: 0.024", "along_m: 0.020"), ("min: 1.0", "min: 0.5")
    loose, _ = planned("wrench", 0, *facing)
    thumb, index = (largest_rate(loose, each) for each in ("thumb", "index"))
    assert thumb == pytest.approx(index, rel=1e-6)
    rate = ("force_rate_max_N_s: 20", f"force_rate_max_N_s: {0.99 * thumb:.9f}")
    with pytest.raises(InfeasibleError, match="force rate") as caught:
        moment("wrench", 0, *facing, rate).plan()
    assert "more time" in caught.value.mend


def test_forces_jump_exactly_where_a_trapezoidal_lift_changes_its_acceleration(
    moment: Fixture, planned: Fixture
) -> None:
    before, (phase, _) = (
        moment("knife", 0, edit("trapezoidal")),
        planned("knife", 0, edit("trapezoidal")),
    )
    total = sum(track.force for track in phase.contacts.values())
    jump = np.diff(total, axis=0)
    expected = before.setting.body.mass * np.diff(phase.tool.linear_acceleration, axis=0)
    np.testing.assert_allclose(jump, expected, atol=1e-9)
    # the jumps are two orders of magnitude above what changes between them
    size = np.sort(np.linalg.norm(jump, axis=1))[::-1]
    assert size[3] > 10.0 * size[4]


@PROFILES
def test_nothing_moves_when_the_tool_is_there_already(moment: Fixture, profile: Profile) -> None:
    before = moment("knife", 0, edit(profile))
    scene = before.setting.scene
    fingers = {scene.contacts[each].finger: scene.contacts[each] for each in before.config.contacts}
    start = Grasp(scene.rest_rotation, fingers)
    options = LiftOptions(1.0, 10, profile)
    phase, after = plan_lift(before.setting, start, start.rotation, options, name="still")
    turn = scene.rest_rotation.inv() * phase.tool.rotation
    # arcsin of a vector part that is zero to rounding
    assert turn.magnitude().max() < 1e-15
    assert phase.reorientation_deg < 1e-13
    np.testing.assert_array_equal(phase.tool.angular_velocity, 0.0)
    np.testing.assert_array_equal(phase.tool.linear_acceleration, 0.0)
    assert (after.rotation.inv() * start.rotation).magnitude() < 1e-15
    for track in phase.contacts.values():
        # the same problem at every sample has the same answer, to the solver's 1e-9 N
        np.testing.assert_allclose(track.force, track.force[:1].repeat(11, axis=0), atol=1e-8)


def test_yaw_of_the_scene_turns_the_whole_lift(moment: Fixture, planned: Fixture) -> None:
    turned = ("yaw_deg: 0\n", "yaw_deg: 35\n")
    straight, _ = planned("wrench", 0)
    yawed, _ = planned("wrench", 0, turned)
    about = Rotation.from_euler("z", 35, degrees=True).as_matrix()
    for name, track in straight.contacts.items():
        # one solver, two frames: its tolerance of 1e-9 relative on forces of a few newtons
        np.testing.assert_allclose(yawed.contacts[name].force, track.force @ about.T, atol=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(("friction: 0.8", "friction: 0.02"), id="friction"),
        pytest.param(("max: 4.0", "max: 1.01"), id="force"),
    ],
)
def test_infeasible_lift_names_the_contact_that_binds_and_a_mend(
    moment: Fixture, change: tuple[str, str]
) -> None:
    with pytest.raises(InfeasibleError, match=r"of (thumb|index|pivot) binds") as caught:
        moment("knife", 0, change).plan()
    assert caught.value.mend
    assert caught.value.exit_code == 1


def largest_rate(phase: Phase, contact: str | None = None) -> float:
    tracks = [t for name, t in phase.contacts.items() if contact in (None, name)]
    change = [np.linalg.norm(np.diff(track.force, axis=0), axis=1) for track in tracks]
    return float(np.max(change) / np.diff(phase.time)[0])
