"""Plans exchanged under way: torques and references join, failures leave the old plan in force."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from pivotgait.control import RecoveryOptions
from pivotgait.control.measurement import Measurement
from pivotgait.control.reference import Reference
from pivotgait.exceptions import InputError
from pivotgait.frozen import Array
from pivotgait.gaits import plan_gait
from pivotgait.models import Scene, load_scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import ReplanOptions, RunOptions, TrialOptions, run_trials
from pivotgait.validation.grasp import with_grasp
from pivotgait.validation.planned import planned_at
from pivotgait.validation.replanning import HANDOVER_S, Replanning, in_phases_of, with_holds

GRASP_S, HOLD_S = 0.5, 0.6
PERIOD_S = 1e-3


@cache
def scene() -> Scene:
    return load_scene("knife")


@cache
def plan() -> GaitPlan:
    return plan_gait(scene())


class Constant:
    """A law that always asks for its own number."""

    def __init__(self, number: float) -> None:
        self.number = number
        self.times: list[float] = []

    def reset(self) -> None:
        self.times.clear()

    def torque(self, measurement: Measurement) -> Array:
        self.times.append(measurement.time)
        return np.full(len(measurement.q), self.number)


def replanning(hold_s: float = HOLD_S) -> tuple[Replanning, list[Constant]]:
    robot, laws = scene().robot, []
    assert robot is not None

    def make(reference: Reference) -> Constant:
        laws.append(Constant(float(len(laws))))
        return laws[-1]

    configs = scene().gaits["default"]
    found = Replanning(plan(), scene(), configs, make, ReplanOptions(hold_s))
    found.begin(Reference.of(with_grasp(found.plan, robot, GRASP_S), robot))
    found.reset()
    return found, laws


def reading(time: float, *, lost: bool = False) -> Measurement:
    """The state that the plan wants before its first removal, or nothing at all."""
    first = plan().phases[3]
    assert first.robot is not None
    still = np.zeros(3)
    place = np.full(3, np.nan) if lost else first.tool.position[0]
    turn = first.tool.rotation[0].as_matrix()
    q = first.robot.q[0]
    return Measurement(time, q, 0.0 * q, {}, place, turn, still, still)


def hold_begins() -> float:
    return GRASP_S + sum(phase.duration_s for phase in plan().phases[:3])


def torques(law: Replanning, start: float, end: float, *, lost: bool = False) -> Array:
    times = np.arange(start, end, PERIOD_S)
    return np.array([law.torque(reading(float(time), lost=lost))[0] for time in times])


def test_a_grasp_held_after_each_addition_but_the_last_joins_its_neighbours() -> None:
    longer = replace(plan(), phases=with_holds(plan().phases, HOLD_S))
    assert [phase.name for phase in longer.phases].count("02_addition") == 2
    assert len(longer.phases) == len(plan().phases) + 1
    reference = Reference.of(longer, scene().robot)
    total = sum(phase.duration_s for phase in plan().phases)
    assert reference.duration == pytest.approx(total + HOLD_S)
    for before, after in pairwise(reference.phases):
        one, other = before.at(before.duration), after.at(0.0)
        np.testing.assert_allclose(one.q, other.q, atol=1e-8)
        np.testing.assert_allclose(one.v, other.v, atol=1e-6)
        np.testing.assert_allclose(one.tool.rotation, other.tool.rotation, atol=1e-8)
        np.testing.assert_allclose(one.tool.position, other.tool.position, atol=1e-9)


def test_torques_go_over_to_the_new_law_without_a_jump() -> None:
    law, laws = replanning()
    begin = hold_begins()
    found = torques(law, begin - 0.1, begin + HOLD_S + 0.1)
    assert found[0] == 0.0
    assert found[-1] == 1.0
    assert np.all(np.diff(found) >= 0.0)
    # a quintic from rest to rest climbs at most 15/8 as fast as a straight line
    assert np.diff(found).max() <= 15.0 / 8.0 * PERIOD_S / HANDOVER_S + 1e-9
    changing = np.flatnonzero((found > 0.0) & (found < 1.0)) * PERIOD_S - 0.1
    assert changing[0] >= HOLD_S - HANDOVER_S - PERIOD_S
    assert changing[-1] <= HOLD_S + PERIOD_S
    assert min(laws[1].times) == pytest.approx(0.0, abs=2 * PERIOD_S)
    (seam,) = law.seams
    assert seam.correction is not None
    assert (seam.after, seam.hold_s) == ("02_addition", HOLD_S)
    assert seam.time_s == pytest.approx(begin - GRASP_S)


def test_the_plan_asked_for_is_as_long_as_the_run_and_joins() -> None:
    law, _ = replanning()
    before = law.duration
    torques(law, hold_begins(), hold_begins() + PERIOD_S / 2)
    moving = sum(phase.duration_s for phase in law.plan.phases)
    assert law.duration == pytest.approx(GRASP_S + moving)
    assert law.duration == pytest.approx(before, abs=0.5)  # relocations take what they take
    assert [phase.name for phase in law.plan.phases].count("02_addition") == 3
    for one, other in pairwise(law.plan.phases):
        assert one.robot is not None
        assert other.robot is not None
        np.testing.assert_allclose(one.robot.q[-1], other.robot.q[0], atol=1e-6)
        np.testing.assert_allclose(one.tool.orientation[-1], other.tool.orientation[0], atol=1e-8)


def test_holds_count_as_the_additions_before_them() -> None:
    law, _ = replanning()
    torques(law, hold_begins(), hold_begins() + PERIOD_S / 2)
    time = np.linspace(-0.5, law.duration + 1.0, 400)
    planned = in_phases_of(plan(), law.plan, planned_at(law.plan, time, ("thumb", "index")))
    assert set(planned.phase) == set(range(len(plan().phases) + 1))
    assert np.all(np.diff(planned.phase) >= 0.0)
    held = (time > hold_begins() - GRASP_S) & (time < hold_begins() - GRASP_S + HOLD_S)
    assert set(planned.phase[held]) == {2.0}


def test_where_planning_fails_the_old_plan_goes_on_and_the_record_says_so() -> None:
    law, laws = replanning()
    asked = law.plan
    found = torques(law, hold_begins(), hold_begins() + HOLD_S + 0.1, lost=True)
    assert not found.any()
    assert len(laws) == 1
    assert law.plan is asked
    (seam,) = law.seams
    assert seam.correction is None
    assert "measured state" in seam.failure
    assert not seam.as_json()["replanned"]


@pytest.mark.parametrize("hold", [0.0, -1.0, 0.5 * HANDOVER_S, float("nan"), float("inf")])
def test_holds_too_short_to_hand_over_are_refused(hold: float) -> None:
    with pytest.raises(InputError, match="hold"):
        ReplanOptions(hold)


def test_a_plan_that_is_no_gait_of_the_scene_is_refused() -> None:
    shorter = replace(plan(), phases=plan().phases[:2])
    with pytest.raises(InputError, match="not those of the gait"):
        Replanning(shorter, scene(), scene().gaits["default"], Constant, ReplanOptions())


@pytest.mark.parametrize(
    "options",
    [
        TrialOptions(RunOptions(recovery=RecoveryOptions()), replanning=ReplanOptions()),
        TrialOptions(pivoting=False, replanning=ReplanOptions()),
    ],
)
def test_what_does_not_go_together_with_it_is_refused(options: TrialOptions) -> None:
    with pytest.raises(InputError, match="does not go together"):
        run_trials(plan(), [0], options)


@pytest.mark.slow
def test_six_gaits_in_a_row_pass_each_planned_anew() -> None:
    walk = plan_gait(load_scene("knife_walk"))
    assert sum(phase.kind == "removal" for phase in walk.phases) >= 6
    options = TrialOptions(perturbed=False, replanning=ReplanOptions())
    (result,) = run_trials(walk, [0], options, workers=1).results
    assert result.verdict.passed, result.verdict
    assert [seam.failure for seam in result.seams] == [""] * 6


@pytest.mark.slow
@pytest.mark.parametrize("perturbed", [False, True])
def test_a_run_planned_anew_passes_and_tells_its_seams(perturbed: bool) -> None:
    options = TrialOptions(
        RunOptions(hold_s=0.3), perturbed=perturbed, replanning=ReplanOptions(HOLD_S)
    )
    found = run_trials(plan(), [2000], options, workers=1)
    (result,) = found.results
    assert result.verdict.passed, result.verdict
    (seam,) = found.as_json()["runs"][0]["replans"]
    assert seam["replanned"], seam
    assert seam["plan_time_s"] > 0.0
    assert found.as_json()["replan_hold_s"] == HOLD_S
