"""The whole search: the same seed gives the same scene, which plans and certifies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pivotgait.certification import certify
from pivotgait.exceptions import InputError
from pivotgait.gait_search import (
    Candidate,
    SearchOptions,
    SearchResult,
    read_contacts,
    read_goal,
    search_gait,
)
from pivotgait.gaits import plan_gait
from pivotgait.models import Scene, load_scene, parse_scene
from pivotgait.plans import GaitPlan

NEAR = "thumb_spine, middle_flat, index_edge_near"
FIRST = "thumb_spine, index_edge"
TOOL = SearchOptions(hand=False, time_limit_s=np.inf)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(scope="module")
def first(scene: Scene) -> tuple[Candidate, ...]:
    return read_contacts(FIRST, scene, where="--first")


@pytest.fixture(scope="module")
def tool_result(scene: Scene, first: tuple[Candidate, ...]) -> SearchResult:
    return search_gait(scene, read_goal(NEAR, scene), first=first, options=TOOL)


def holding(plan: GaitPlan) -> set[str]:
    """Fingers that press at the end."""
    last = plan.phases[-1]
    return {n for n, each in last.contacts.items() if np.linalg.norm(each.force[-1]) > 1e-6}


def test_the_papers_sequence_is_found_from_its_first_grasp(tool_result: SearchResult) -> None:
    found = tool_result.found
    assert found is not None
    assert [move.name for move in found.moves] == [
        "lift thumb_spine, index_edge",
        "+middle_flat",
        "-index_edge",
        "+index_edge_near",
    ]
    assert found.certificate.valid
    assert holding(found.plan) == {"pivot", "thumb", "index", "middle"}
    assert tool_result.ended == "found"


def test_the_same_seed_gives_the_same_scene(
    scene: Scene, first: tuple[Candidate, ...], tool_result: SearchResult
) -> None:
    again = search_gait(scene, read_goal(NEAR, scene), first=first, options=TOOL)
    assert again.found is not None
    assert tool_result.found is not None
    assert again.found.found.text == tool_result.found.found.text
    assert again.deaths.counts == tool_result.deaths.counts


def test_a_found_scene_replays_from_its_text_alone(tool_result: SearchResult) -> None:
    assert tool_result.found is not None
    gait = tool_result.found
    scene = parse_scene(gait.found.text)
    assert list(scene.gaits) == ["default"]
    for name, contact in scene.contacts.items():
        assert np.array_equal(contact.point, gait.found.scene.contacts[name].point)
    plan = plan_gait(scene)
    assert certify(plan).valid
    for one, other in zip(plan.phases, gait.plan.phases, strict=True):
        assert np.array_equal(one.tool.orientation, other.tool.orientation)


def test_its_estimate_is_near_what_the_plan_costs(tool_result: SearchResult) -> None:
    assert tool_result.found is not None
    cost, estimate = tool_result.found.cost, tool_result.found.estimate
    assert estimate.reorientation_rad == pytest.approx(cost.reorientation_rad, abs=0.03)
    assert estimate.time_s == pytest.approx(cost.time_s, abs=1e-9)


def test_a_goal_that_forces_forbid_is_said_to_be_impossible_at_once(
    scene: Scene, first: tuple[Candidate, ...]
) -> None:
    """Two fingers on one side of the handle hold nothing."""
    goal = read_goal("thumb@0.09/0, index@0.07/0", scene)
    result = search_gait(scene, goal, first=first, options=TOOL)
    assert result.found is None
    assert result.ended == "impossible"
    assert result.news.plans == 0
    assert ("order of fingers", "the goal holds in no attitude", 1) in result.deaths.rows()


@pytest.mark.parametrize(
    "options",
    [
        {"time_limit_s": 0.0},
        {"time_limit_s": np.nan},
        {"inflation": 0.5},
        {"visits": 0},
        {"plans": 0},
        {"sequences": 0},
    ],
)
def test_options_are_checked(options: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(options))):
        SearchOptions(**options)  # type: ignore[arg-type]


def test_a_negative_seed_is_refused(scene: Scene) -> None:
    with pytest.raises(InputError, match="seed"):
        search_gait(scene, read_goal(NEAR, scene), seed=-1)


@pytest.mark.slow
@pytest.mark.parametrize("goal", [NEAR, "power-grasp by thumb"])
def test_the_hands_gait_is_found_from_the_goal_alone_and_replays(
    scene: Scene, goal: str, tmp_path: Path
) -> None:
    options = SearchOptions(time_limit_s=300.0)
    result = search_gait(scene, read_goal(goal, scene), options=options)
    assert result.found is not None
    assert result.found.palm_m <= read_goal(goal, scene).palm_max_m
    file = tmp_path / "found.yaml"
    file.write_text(result.found.found.text)
    plan = plan_gait(load_scene(file))
    assert certify(plan).valid
    for one, other in zip(plan.phases, result.found.plan.phases, strict=True):
        assert one.robot is not None
        assert other.robot is not None
        assert np.array_equal(one.robot.q, other.robot.q)
