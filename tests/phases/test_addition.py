"""Additions: one finger's load grows on a straight line while the tool rests (eq. 8)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pivotgait.dynamics import pivot_motion
from pivotgait.exceptions import InfeasibleError
from pivotgait.forces import allocate
from pivotgait.phases.allocation import allocation_problem
from pivotgait.plans import Phase

Fixture = Callable[..., Any]
EVERY = pytest.mark.parametrize(
    ("name", "place"),
    [
        ("knife", 1),
        ("screwdriver", 1),
        ("wrench", 1),
        ("knife", 3),
        ("screwdriver", 3),
        ("wrench", 3),
    ],
)


@EVERY
def test_addition_keeps_every_law(
    moment: Fixture, planned: Fixture, assert_laws: Fixture, name: str, place: int
) -> None:
    before, (phase, _) = moment(name, place), planned(name, place)
    assert before.grasp.forces  # the seam with the phase before is part of the laws
    assert_laws(before, phase)
    assert phase.kind == "addition"
    assert phase.finger == before.finger


@EVERY
def test_tool_rests(moment: Fixture, planned: Fixture, name: str, place: int) -> None:
    before, (phase, after) = moment(name, place), planned(name, place)
    assert phase.reorientation_deg < 1e-12
    np.testing.assert_array_equal(phase.tool.angular_velocity, 0.0)
    np.testing.assert_array_equal(phase.tool.linear_velocity, 0.0)
    assert (before.grasp.rotation.inv() * after.rotation).magnitude() < 1e-14


@EVERY
def test_normal_force_follows_the_ramp(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    before, (phase, _) = moment(name, place), planned(name, place)
    track = phase.contacts[before.finger]
    along = np.sum(track.force * track.world_normal(phase.tool), axis=1)
    share = np.arange(len(along)) / (len(along) - 1)
    # an equality of the solver: its 1e-9 N, against the certificate's 1e-6 N
    np.testing.assert_allclose(along, share * along[-1], atol=1e-9)
    np.testing.assert_array_equal(track.force[0], 0.0)
    assert along[-1] >= before.setting.scene.contacts[before.config.contact].normal_min
    assert track.normal_min == 0.0


@EVERY
def test_forces_end_where_the_new_grasp_wants_them(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    before, (phase, after) = moment(name, place), planned(name, place)
    setting, scene = before.setting, before.setting.scene
    fingers = [*before.grasp.fingers.values(), scene.contacts[before.config.contact]]
    rotation = phase.tool.rotation[:1]
    rest = pivot_motion(setting.body, rotation, np.zeros((1, 3)), np.zeros((1, 3)))
    wanted = allocate(allocation_problem(setting, rest, fingers)).require()
    for name_, force in zip(wanted.problem.names, wanted.force[0], strict=True):
        # prescribed to the solver as an equality: 1e-9 N
        np.testing.assert_allclose(phase.contacts[name_].force[-1], force, atol=1e-8)
        np.testing.assert_array_equal(after.forces[name_], phase.contacts[name_].force[-1])
    assert list(after.fingers) == [*before.grasp.fingers, before.finger]


@EVERY
def test_rate_of_every_force_is_kept(
    moment: Fixture, planned: Fixture, name: str, place: int
) -> None:
    phase, _ = planned(name, place)
    limit = moment(name, place).setting.scene.allocation.force_rate_max_N_s
    # the solver's 1e-9 N per step of a millisecond or more is 1e-6 N/s
    assert largest_rate(phase) <= limit + 1e-6


@EVERY
def test_shortest_duration_is_the_largest_change_over_the_rate(
    moment: Fixture, planned: Fixture, assert_laws: Fixture, name: str, place: int
) -> None:
    # at rest the possible forces are a convex set, so the straight line between the ends is
    # possible, and no path from end to end has a smaller largest rate
    before, (long, _) = moment(name, place), planned(name, place)
    limit = before.setting.scene.allocation.force_rate_max_N_s
    change = [np.linalg.norm(t.force[-1] - t.force[0]) for t in long.contacts.values()]
    shortest = float(np.max(change)) / limit
    config = before.config.model_copy(update={"duration_s": 0.99 * shortest, "steps": 8})
    with pytest.raises(InfeasibleError, match="force rate") as caught:
        replace(before, config=config).plan()
    assert "more time" in caught.value.mend
    config = before.config.model_copy(update={"duration_s": 1.01 * shortest, "steps": 8})
    phase, _ = replace(before, config=config).plan()
    assert_laws(replace(before, config=config), phase)
    assert largest_rate(phase) <= limit + 1e-6  # as below
    assert largest_rate(phase) >= limit / 1.01 - 1e-6


def test_a_contact_that_cannot_help_is_infeasible_and_named(moment: Fixture) -> None:
    before = moment("wrench", 1)
    scene = before.setting.scene
    # it must push up with more than the weight of the whole tool, against fingers that slip
    strong = replace(scene.contacts["middle_below"], normal_min=30.0, normal_max=40.0)
    forced = replace(scene, contacts={**scene.contacts, "middle_below": strong})
    setting = replace(before.setting, scene=forced)
    with pytest.raises(InfeasibleError, match=r"of (thumb|index|middle|pivot) binds"):
        replace(before, setting=setting).plan()


def largest_rate(phase: Phase) -> float:
    step = np.diff(phase.time)[0]
    change = [np.linalg.norm(np.diff(t.force, axis=0), axis=1) for t in phase.contacts.values()]
    return float(np.max(change) / step)
