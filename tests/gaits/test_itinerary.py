"""Key poses are moments of the steps, in order, and every stop keeps the one it stands for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pivotgait.exceptions import SceneError
from pivotgait.gaits.itinerary import Itinerary, Stop, contacts_left
from pivotgait.gaits.steps import Step, plan_steps
from pivotgait.models import AdditionPhase, LiftPhase, RelocationPhase, RemovalPhase, load_scene
from pivotgait.phases.grasp import Setting

KNIFE = load_scene("knife")
LIFT, BEFORE, ADDITION, REMOVAL, AGAIN, LAST = range(6)


@cache
def steps() -> tuple[Step, ...]:
    return plan_steps(Setting.of(KNIFE), KNIFE.gaits["default"])


@pytest.fixture
def itinerary() -> Itinerary:
    return Itinerary.of(KNIFE, steps())


def check(found: Itinerary, of: Sequence[Step]) -> None:
    """Stops rise, neighbours join, and each key is the step's pose at its sample."""
    assert len(found.stops) == len(of)
    assert found.stops[0][0] == Stop(0, 0)
    for step, stops, following in zip(of, found.stops, (*found.stops[1:], None), strict=True):
        assert [s.sample for s in stops] == sorted({s.sample for s in stops})
        assert [s.key for s in stops] == list(range(stops[0].key, stops[0].key + len(stops)))
        if following is not None:
            assert following[0] == Stop(0, stops[-1].key)
        else:
            assert stops[-1].key == len(found.keys) - 1
        if step.phase is None:
            continue
        assert len(stops) == 1 or stops[-1].sample == len(step.phase.time) - 1
        for stop in stops:
            key, tool = found.keys[stop.key], step.phase.tool
            turn = tool.rotation[stop.sample].as_matrix()
            np.testing.assert_allclose(key.rotation, turn, atol=1e-12)
            np.testing.assert_allclose(key.position, tool.position[stop.sample], atol=1e-12)


def names(found: Itinerary, key: int) -> set[str]:
    return {contact.name for contact in found.keys[key].contacts.values()}


def test_keys_and_stops_of_the_knife_s_gait(itinerary: Itinerary) -> None:
    kinds = [type(step.config) for step in steps()]
    assert kinds == [
        LiftPhase,
        RelocationPhase,
        AdditionPhase,
        RemovalPhase,
        RelocationPhase,
        AdditionPhase,
    ]
    check(itinerary, steps())
    lift, removal = (len(steps()[k].phase.time) - 1 for k in (LIFT, REMOVAL))
    assert itinerary.stops == (
        (Stop(0, 0), Stop(lift // 2, 1), Stop(lift, 2)),
        (Stop(0, 2), Stop(1, 3)),
        (Stop(0, 3),),
        (Stop(0, 3), Stop(removal // 2, 4), Stop(removal, 5)),
        (Stop(0, 5), Stop(1, 6)),
        (Stop(0, 6),),
    )
    first, three = {"thumb_spine", "index_edge"}, {"thumb_spine", "index_edge", "middle_flat"}
    assert [names(itinerary, k) for k in range(4)] == [first, first, first, three]
    # while the index finger's force dies away it still is there; then it is free to go
    assert names(itinerary, 4) == three
    assert names(itinerary, 6) == {"thumb_spine", "middle_flat", "index_edge_near"}


def test_a_relocation_s_key_is_at_the_tool_s_resting_place(itinerary: Itinerary) -> None:
    for place in (BEFORE, AGAIN):
        end = itinerary.keys[itinerary.stops[place][-1].key]
        start = itinerary.keys[itinerary.stops[place][0].key]
        np.testing.assert_allclose(end.rotation, start.rotation, atol=1e-12)
        np.testing.assert_allclose(end.position, start.position, atol=1e-12)
        assert end.name == f"end of {steps()[place].name}"


@pytest.mark.parametrize("step", [LIFT, REMOVAL])
@pytest.mark.parametrize("sample", [1, 20, 45])
def test_one_more_stop(itinerary: Itinerary, step: int, sample: int) -> None:
    more, new = itinerary.with_stop(steps(), step, sample)
    check(more, steps())
    assert len(more.keys) == len(itinerary.keys) + 1
    assert Stop(sample, new) in more.stops[step]
    assert f"{steps()[step].phase.time[sample]:.2f} s" in more.keys[new].name
    kept = [key for k, key in enumerate(more.keys) if k != new]
    assert all(a is b for a, b in zip(kept, itinerary.keys, strict=True))
    samples = [[stop.sample for stop in stops] for stops in itinerary.stops]
    samples[step] = sorted([*samples[step], sample])
    assert [[stop.sample for stop in stops] for stops in more.stops] == samples


def test_stops_pile_up_in_any_order(itinerary: Itinerary) -> None:
    more = itinerary
    for place, sample in ((REMOVAL, 60), (LIFT, 3), (REMOVAL, 5), (LIFT, 2), (LIFT, 70)):
        more, _ = more.with_stop(steps(), place, sample)
        check(more, steps())
    assert len(more.keys) == len(itinerary.keys) + 5


def test_renewed_on_the_same_steps_it_is_the_same(itinerary: Itinerary) -> None:
    itinerary, _ = itinerary.with_stop(steps(), REMOVAL, 10)
    again = itinerary.renewed(steps())
    assert again.stops == itinerary.stops
    for new, old in zip(again.keys, itinerary.keys, strict=True):
        assert new.name == old.name
        assert new.contacts == old.contacts
        np.testing.assert_allclose(new.rotation, old.rotation, atol=1e-12)
        np.testing.assert_allclose(new.position, old.position, atol=1e-12)


def test_renewed_it_follows_steps_that_have_changed(itinerary: Itinerary) -> None:
    """Another removal: its keys and the relocation after it move, what was before does not."""
    itinerary, _ = itinerary.with_stop(steps(), REMOVAL, 10)
    lighter = Setting.of(replace(KNIFE, gravity=np.array([0.0, 0.0, -9.0])))
    changed = plan_steps(lighter, KNIFE.gaits["default"])
    renewed = itinerary.renewed(changed)
    check(renewed, changed)
    assert renewed.stops == itinerary.stops
    end = itinerary.stops[REMOVAL][-1].key
    assert not np.allclose(renewed.keys[end].rotation, itinerary.keys[end].rotation, atol=1e-6)
    after = renewed.keys[renewed.stops[AGAIN][-1].key]
    np.testing.assert_allclose(after.rotation, renewed.keys[end].rotation, atol=1e-12)
    assert names(renewed, itinerary.stops[AGAIN][-1].key) == names(
        itinerary, itinerary.stops[AGAIN][-1].key
    )


def test_an_addition_needs_a_relocation() -> None:
    without = [step for k, step in enumerate(steps()) if k != BEFORE]
    with pytest.raises(
        SceneError, match=r"^02_addition: nothing brings finger 'middle' to 'middle_flat'"
    ) as caught:
        Itinerary.of(KNIFE, without)
    assert "relocation" in caught.value.mend


def test_contacts_that_fingers_leave() -> None:
    left = dict(contacts_left(KNIFE, steps()))
    assert {name: contact.name for name, contact in left.items()} == {"04_relocation": "index_edge"}


def suggesting(positions: Sequence[float | None]) -> tuple[Step, ...]:
    """The steps, each moving one with a posture of the first joint, unless that is None."""
    at = iter(positions)
    found = []
    for step in steps():
        if isinstance(step.config, LiftPhase | RemovalPhase | RelocationPhase):
            value = next(at)
            posture = {} if value is None else {"J1": value}
            step = replace(step, config=step.config.model_copy(update={"posture": posture}))
        found.append(step)
    return tuple(found)


def test_suggested_postures_end_phases_and_are_between_them_in_the_middle(
    itinerary: Itinerary,
) -> None:
    robot = KNIFE.robot
    assert robot is not None
    wished = (0.1, 0.2, 0.4, 0.8)
    found = itinerary.postures_suggested(suggesting(wished), robot)
    assert found is not None
    assert found.shape == (len(itinerary.keys), robot.nv)
    joint = found[:, robot.joint_names.index("J1")]
    ends = [itinerary.stops[k][-1].key for k in (LIFT, BEFORE, REMOVAL, AGAIN)]
    assert joint[ends] == pytest.approx(wished)
    middle = itinerary.stops[REMOVAL][1].key
    assert joint[middle] == pytest.approx(0.5 * (0.2 + 0.4))
    assert joint[: ends[0]] == pytest.approx([0.1] * ends[0])
    others = [k for k in range(robot.nv) if k != robot.joint_names.index("J1")]
    np.testing.assert_array_equal(
        found[:, others], np.broadcast_to(robot.home[others], (len(found), len(others)))
    )


@pytest.mark.parametrize("missing", range(4))
def test_suggestions_count_only_if_every_moving_phase_has_one(
    itinerary: Itinerary, missing: int
) -> None:
    robot = KNIFE.robot
    assert robot is not None
    wished = [None if k == missing else 0.1 for k in range(4)]
    assert itinerary.postures_suggested(suggesting(wished), robot) is None
