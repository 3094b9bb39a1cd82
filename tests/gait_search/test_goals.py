"""Goals: what they say is missing never exceeds what is; bad words are refused in one line."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.gait_search import Candidate, NamedGrasp, PowerGrasp, handle_candidates, read_goal
from pivotgait.gait_search.goals import Goal
from pivotgait.models import Scene, load_scene

THREE = "thumb_spine, middle_flat, index_edge_near"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene("knife")


@pytest.fixture(
    scope="module",
    params=[
        THREE,
        "thumb_spine, index_edge",
        "power-grasp",
        "lifted off by thumb and index",
        "lifted off by thumb_spine and index_edge",
    ],
)
def goal(request: pytest.FixtureRequest, scene: Scene) -> Goal:
    return read_goal(request.param, scene)


@pytest.fixture(scope="module")
def some(scene: Scene) -> list[Candidate]:
    everything = list(handle_candidates(scene).values())
    return everything[:4] + everything[4::17]


def grasp(rng: np.random.Generator, some: list[Candidate]) -> dict[str, Candidate]:
    picked = rng.choice(len(some), 3)
    return {some[k].finger: some[k] for k in picked}


def test_nothing_is_missing_where_the_goal_is_reached_and_only_there(
    goal: Goal, some: list[Candidate]
) -> None:
    rng, reached = np.random.default_rng(1), 0
    own = {each.finger: each for each in goal.contacts.values()}
    two = {some[0].finger: some[0], some[1].finger: some[1]}
    for fingers in [own, two, *(grasp(rng, some) for _ in range(600))]:
        missing = goal.missing(fingers)
        if goal.reached(fingers):
            reached += 1
            assert (missing.additions, missing.removals) == (0, 0)
        elif fingers:
            assert missing.additions + missing.removals > 0
    assert reached


def test_one_move_brings_the_goal_one_move_nearer_at_most(
    goal: Goal, some: list[Candidate]
) -> None:
    """Consistency: else the search's estimate could exceed the true rest."""
    rng = np.random.default_rng(2)
    for _ in range(300):
        held = grasp(rng, some)
        if len(held) < 2:
            continue
        before = goal.missing(held)
        for each in some:
            if each.finger not in held:
                after = goal.missing({**held, each.finger: each})
                assert before.additions <= after.additions + 1
                assert before.removals <= after.removals
        for finger in held if len(held) > 2 else ():
            after = goal.missing({name: each for name, each in held.items() if name != finger})
            assert before.removals <= after.removals + 1
            assert before.additions <= after.additions


def test_words_name_contacts_of_the_scene_and_places_of_ones_own(scene: Scene) -> None:
    named = read_goal("thumb_spine,  index@0.05/180", scene)
    assert isinstance(named, NamedGrasp)
    assert [each.finger for each in named.contacts.values()] == ["thumb", "index"]
    (_, own) = named.contacts.values()
    assert (own.along_m, own.around_deg) == (0.05, 180.0)
    assert own.contact.friction == scene.contacts["index_edge"].friction


@pytest.mark.parametrize(
    ("text", "palm", "by"),
    [
        ("power-grasp", 0.06, None),
        ("power grasp within 0.04 m", 0.04, None),
        ("power-grasp by thumb", 0.06, "thumb"),
        ("power-grasp by thumb within 0.05 m", 0.05, "thumb"),
    ],
)
def test_words_of_a_power_grasp(scene: Scene, text: str, palm: float, by: str | None) -> None:
    goal = read_goal(text, scene)
    assert isinstance(goal, PowerGrasp)
    assert (goal.palm_max_m, goal.by) == (palm, by)


def test_a_power_grasp_needs_two_fingers_that_the_third_opposes(scene: Scene) -> None:
    def at(*places: str) -> dict[str, Candidate]:
        goal = read_goal(", ".join(places), scene)
        return {each.finger: each for each in goal.contacts.values()}

    around, beside = (
        at("thumb@0.04/0", "index@0.03/180", "middle@0.06/180"),
        at("thumb@0.04/0", "index@0.03/180", "middle@0.06/90"),
    )
    assert PowerGrasp().reached(around)
    assert not PowerGrasp().reached(beside)
    assert not PowerGrasp(by="index").reached(around)
    assert not PowerGrasp().reached({name: around[name] for name in ("thumb", "index")})
    assert not PowerGrasp().reached(MappingProxyType({}))


BAD = {
    "": "is empty",
    "nothing": "unknown contact",
    "thumb_spine": "names 1 contact",
    "thumb_spine, thumb@0.05/0": "two places",
    "thumb_spine, toe@0.05/0": "unknown finger",
    "thumb_spine, index@a/0": "cannot read the place",
    "thumb_spine, index@nan/0": "cannot read the place",
    "thumb_spine, index@0.5/0": "off the handle",
    "power-grasp within -1 m": "cannot be within",
    "power-grasp within near m": "cannot read",
    "power-grasp by toe": "unknown finger",
    "lifted off by thumb and toe": "unknown finger",
    "lifted off by thumb": "two fingers",
    "lifted off by thumb_spine": "names 1 contact",
    "lifted off by thumb_spine and nothing": "unknown contact",
}


@pytest.mark.parametrize("text", BAD)
def test_bad_words_are_refused_in_one_line(scene: Scene, text: str) -> None:
    with pytest.raises(InputError, match=BAD[text]) as caught:
        read_goal(text, scene)
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)


def test_an_unknown_contact_is_answered_with_those_there_are(scene: Scene) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'index_edge'"):
        read_goal("thumb_spine, index_egde", scene)
