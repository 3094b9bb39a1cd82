"""Candidates lie on the tool's surface, with unit inward normals; the hand's palm and reach."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pinocchio as pin
import pytest

from pivotgait.exceptions import InputError
from pivotgait.gait_search import CandidateOptions, handle_candidates
from pivotgait.gait_search.hand_reach import HandReach, palm_in_tool
from pivotgait.gait_search.palm import PalmDistance
from pivotgait.models import HandleContact, Scene, load_scene
from pivotgait.models.coal_shapes import ball_distance

SCENES = ("knife", "screwdriver", "wrench")
BALL_M, GAP_M = 5e-4, 1e-3


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> Scene:
    return load_scene(request.param)


@pytest.fixture(scope="module")
def knife() -> Scene:
    return load_scene("knife")


def test_candidates_lie_on_the_surface_with_unit_inward_normals(scene: Scene) -> None:
    found = handle_candidates(scene)
    assert len(found) > 60
    for each in found.values():
        point, normal = each.contact.point, each.contact.normal
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
        shapes = scene.tool.shapes
        # a ball over the place sees the surface at the gap's distance, straight below it
        centre = point - (BALL_M + GAP_M) * normal
        outside = min(ball_distance(shape, centre, BALL_M)[0] for shape in shapes)
        assert outside == pytest.approx(GAP_M, abs=1e-6)
        inside = min(ball_distance(shape, point + 2e-4 * normal, 1e-5)[0] for shape in shapes)
        assert inside < 0.0


def test_the_scenes_own_contacts_come_first_and_names_are_unique(scene: Scene) -> None:
    found = handle_candidates(scene)
    assert list(found)[: len(scene.contacts)] == list(scene.contacts)
    for name, each in found.items():
        assert name == each.name
    places = {(each.finger, each.along_m, each.around_deg % 360) for each in found.values()}
    assert len(places) == len(found)


def test_a_candidate_is_where_the_scene_would_put_it(knife: Scene) -> None:
    for each in list(handle_candidates(knife).values())[:40]:
        place = knife.tool.place(each.along_m, np.radians(each.around_deg))
        assert np.allclose(place.point, each.contact.point, atol=1e-12)
        assert np.allclose(place.normal, each.contact.normal, atol=1e-12)


def test_a_finer_grid_has_more_places_and_losses_are_counted(knife: Scene) -> None:
    lost: Counter[str] = Counter()
    coarse = handle_candidates(knife, CandidateOptions(along_step_m=0.02), lost)
    fine = handle_candidates(knife, CandidateOptions(along_step_m=0.005))
    assert len(fine) > 2 * len(coarse)
    assert lost.total() > 0


@pytest.mark.parametrize("name", ["along_step_m", "around_step_deg", "end_margin_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_steps_must_be_positive(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        CandidateOptions(**{name: value})


def test_the_palm_moves_away_with_the_tool(knife: Scene) -> None:
    robot = knife.robot
    assert robot is not None
    distance = PalmDistance(robot, knife.tool)
    rotation, place = knife.rest_rotation.as_matrix(), knife.rest_position
    here = distance(robot.home, rotation, place)
    assert here > 0.0
    for shift in (0.01, 0.1, 10.0):
        for axis in np.eye(3):
            there = distance(robot.home, rotation, place + shift * axis)
            assert abs(there - here) <= shift + 1e-6
    assert distance(robot.home, rotation, place + 10.0 * np.eye(3)[0]) > 9.0
    with pytest.raises(InputError):
        distance(robot.home, rotation, place + np.nan)


def test_a_fingertip_reaches_where_it_is(knife: Scene) -> None:
    robot = knife.robot
    assert robot is not None
    reach, data = HandReach(robot, knife.clearance), robot.model.createData()
    rotation, place = knife.rest_rotation.as_matrix(), knife.rest_position
    rng = np.random.default_rng(5)
    palm = palm_in_tool(robot, robot.home, rotation, place)
    tool = pin.SE3(rotation, np.array(place))
    for name, finger in robot.fingers.items():
        q, columns = np.array(robot.home), list(finger.columns)
        middle = 0.5 * (robot.lower[columns] + robot.upper[columns])
        q[columns] = middle + 0.1 * rng.uniform(-1.0, 1.0, len(columns))
        pin.framesForwardKinematics(robot.model, data, q)
        tip = tool.actInv(data.oMf[finger.tip_frame_id])
        inward = tip.rotation @ finger.pad
        point = tip.translation + finger.tip_radius * inward
        near = HandleContact("near", name, point, inward, 0.8, 0.1, 1.0)
        far = HandleContact("far", name, point + 0.5 * np.eye(3)[2], inward, 0.8, 0.1, 1.0)
        assert reach.miss(near, palm) < 0.01
        assert reach.miss(far, palm) > 0.1


def test_tips_are_admitted_between_touching_and_the_farthest_reach(knife: Scene) -> None:
    assert knife.robot is not None
    reach = HandReach(knife.robot, knife.clearance)
    distances = np.array([0.001, 0.05, 1.0])
    assert reach.admits("thumb", "index", distances).tolist() == [False, True, False]
    there, back = (
        reach.admits(*pair, distances) for pair in (("thumb", "index"), ("index", "thumb"))
    )
    assert there.tolist() == back.tolist()
