"""A plan that ends off the table is valid; each single change of it is named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pivotgait.certification import TOOL_LIMITS, TRANSFER_LIMITS, certify
from pivotgait.gaits import plan_gait
from pivotgait.models import load_scene
from pivotgait.plans import ContactTrack, GaitPlan, read_plan, write_plan

Mutation = Callable[[GaitPlan], GaitPlan]
ROW = 55


@pytest.fixture(scope="module")
def plan() -> GaitPlan:
    return plan_gait(load_scene("screwdriver"), hand=False)


def in_last(plan: GaitPlan, **changes: object) -> GaitPlan:
    return replace(plan, phases=(*plan.phases[:-1], replace(plan.phases[-1], **changes)))


def in_motion(field: str, row: int, change: float) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        array = np.array(getattr(plan.phases[-1].tool, field))
        array[row, 2] += change
        return in_last(plan, tool=replace(plan.phases[-1].tool, **{field: array}))

    return mutate


def in_contact(name: str, change: Callable[[ContactTrack], ContactTrack]) -> Mutation:
    def mutate(plan: GaitPlan) -> GaitPlan:
        contacts = dict(plan.phases[-1].contacts)
        contacts[name] = change(contacts[name])
        return in_last(plan, contacts=contacts)

    return mutate


def bumped(values: np.ndarray, row: int, change: object) -> np.ndarray:
    array = np.array(values)
    array[row] += change
    return array


def whole(plan: GaitPlan, field: str, change: float) -> GaitPlan:
    array = np.array(getattr(plan.phases[-1].tool, field))
    array[:, 2] += change
    return in_last(plan, tool=replace(plan.phases[-1].tool, **{field: array}))


MUTATIONS: dict[str, tuple[Mutation, set[str]]] = {
    "height": (in_motion("position", ROW, 1e-4), {"rise_excess_m"}),
    "speed": (in_motion("linear_velocity", ROW, 0.1), {"rise_rate_excess_m_s"}),
    "start with speed": (in_motion("linear_velocity", 0, 1e-3), {"rest_m_s"}),
    "table pushes a tool off it": (
        in_contact("pivot", lambda c: replace(c, force=bumped(c.force, ROW, [0.0, 0.0, 1e-3]))),
        {"borne_tip_m"},
    ),
    "tip in the table": (lambda plan: whole(plan, "position", -1e-5), {"tip_depth_m"}),
    "moment": (
        in_contact("thumb", lambda c: replace(c, moment=bumped(c.moment, ROW, 1e-5))),
        {"moment_balance_nm"},
    ),
    "moment at the seam": (
        in_contact("thumb", lambda c: replace(c, moment=bumped(c.moment, 0, 1e-5))),
        {"seam_moment_nm"},
    ),
    "no torsion": (in_contact("thumb", lambda c: replace(c, torsion=0.0)), {"cone_margin_n"}),
    "less torsion": (in_contact("thumb", lambda c: replace(c, torsion=1e-5)), {"cone_margin_n"}),
}


def test_a_plan_off_the_table_is_valid(plan: GaitPlan) -> None:
    found = certify(plan)
    assert found.valid, found.violations
    assert found.residuals.keys() == {*TOOL_LIMITS, *TRANSFER_LIMITS}


@pytest.mark.parametrize("name", MUTATIONS)
def test_each_change_is_named(plan: GaitPlan, name: str) -> None:
    mutate, wanted = MUTATIONS[name]
    assert wanted <= {violation.what for violation in certify(mutate(plan)).violations}


def test_every_limit_is_missed_by_some_change() -> None:
    assert set().union(*(wanted for _, wanted in MUTATIONS.values())) >= set(TRANSFER_LIMITS)


def test_torsion_and_moments_survive_the_file(plan: GaitPlan, tmp_path) -> None:
    write_plan(plan, tmp_path / "plan.h5")
    again = read_plan(tmp_path / "plan.h5")
    for name in ("thumb", "middle"):
        ours, theirs = (each.phases[-1].contacts[name] for each in (plan, again))
        assert ours.torsion == theirs.torsion > 0.0
        np.testing.assert_array_equal(ours.moment, theirs.moment)
    assert again.phases[-1].contacts["pivot"].moment is None
