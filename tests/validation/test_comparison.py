"""Trials crossed, causes looked for, files read back, and engines that are missing."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pivotgait.exceptions import InputError, UnknownNameError
from pivotgait.models import Scene
from pivotgait.plans import GaitPlan
from pivotgait.validation import (
    Agreement,
    CarriedOut,
    CompareOptions,
    Comparison,
    Metrics,
    RecordError,
    RunOptions,
    RunSeries,
    SimulatorOptions,
    Stage,
    TrialOptions,
    TrialResult,
    TrialSet,
    Verdict,
    compare_engines,
    compare_runs,
    plan_digest,
)
from pivotgait.validation import comparison as module
from pivotgait.validation.agreement_causes import CHANGES, look_for_cause
from pivotgait.validation.agreement_trials import TrialAgreement
from pivotgait.validation.comparison_files import (
    FOUND,
    read_comparison,
    run_file,
    write_comparison,
)
from pivotgait.validation.planned import planned_at

PASSED, SLIP, LOSS = Verdict(True), *(Verdict(False, each, "x") for each in ("slip", "loss"))
METRICS = Metrics(0.04, 0.05, 0.2, 0.5, 0.3, 0.2)


def trials(simulator: str, verdicts: list[Verdict], seed: int = 0) -> TrialSet:
    results = tuple(TrialResult(seed + k, each) for k, each in enumerate(verdicts))
    return TrialSet(TrialOptions(RunOptions(simulator=simulator)), (), results)


def crossed(one: list[Verdict], two: list[Verdict]) -> TrialAgreement:
    return TrialAgreement((trials("pybullet", one), trials("mujoco", two)))


def test_a_textbook_kappa() -> None:
    # 20 both yes, 15 both no, 5 and 10 apart: Cohen's example, kappa 0.4
    one = [PASSED] * 25 + [SLIP] * 25
    two = [PASSED] * 20 + [SLIP] * 5 + [PASSED] * 10 + [SLIP] * 15
    found = crossed(one, two)
    assert found.same_verdict == 35
    assert found.kappa == pytest.approx(0.4)
    low, high = found.as_json()["same_verdict_wilson_95"]
    assert 0.0 < low < 0.7 < high < 1.0


def test_kappa_is_one_where_all_agree_and_none_where_all_pass() -> None:
    assert crossed([PASSED, SLIP], [PASSED, LOSS]).kappa == pytest.approx(1.0)
    assert crossed([PASSED] * 3, [PASSED] * 3).kappa is None
    assert crossed([PASSED] * 3, [PASSED] * 3).same_verdict == 3


def test_outcomes_are_crossed_by_class() -> None:
    found = crossed([PASSED, SLIP, SLIP, LOSS], [PASSED, LOSS, SLIP, PASSED])
    assert found.crossed == {
        ("passed", "passed"): 1,
        ("slip", "loss"): 1,
        ("slip", "slip"): 1,
        ("loss", "passed"): 1,
    }
    assert (found.same_verdict, found.same_outcome) == (3, 2)
    told = found.as_json()
    assert [each["seed"] for each in told["differing"]] == [1, 3]
    assert sum(each["trials"] for each in told["crossed"]) == found.trials


def test_metrics_are_compared_where_both_ran() -> None:
    pair = [trials(name, [PASSED] * 3) for name in ("pybullet", "mujoco")]
    slips = ((0.5, 0.6, 0.5), (0.5, 0.5, 0.8))
    sets = [
        replace(
            each,
            results=tuple(
                replace(r, metrics=replace(METRICS, tip_slip_mm=mm))
                for r, mm in zip(each.results, own, strict=True)
            ),
        )
        for each, own in zip(pair, slips, strict=True)
    ]
    found = TrialAgreement((sets[0], sets[1])).metric_differences
    assert found["tip_slip_mm"] == (pytest.approx(0.1), pytest.approx(0.3))
    assert found["orientation_deg"] == (0.0, 0.0)


def test_seeds_with_other_plans_are_told(plan: GaitPlan, faithful: RunSeries) -> None:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    other = replace(planned, force=1.01 * planned.force)
    short = planned.every(1)
    short = replace(short, **{name: values[:50] for name, values in vars(short).items()})
    columns = [(planned, None, None, planned, planned), (short, None, planned, other, planned)]
    sets = [
        TrialSet(
            TrialOptions(RunOptions(simulator=name)),
            (),
            tuple(TrialResult(k, PASSED, planned=each) for k, each in enumerate(column)),
        )
        for name, column in zip(("pybullet", "mujoco"), columns, strict=True)
    ]
    found = TrialAgreement((sets[0], sets[1]))
    assert found.unlike_plans == (2, 3)
    assert found.as_json()["unlike_plans"] == [2, 3]


def test_other_seeds_are_no_comparison() -> None:
    with pytest.raises(InputError, match="seeds"):
        TrialAgreement((trials("pybullet", [PASSED]), trials("mujoco", [PASSED], seed=1)))


@pytest.fixture
def agreement(plan: GaitPlan, scene: Scene, faithful: RunSeries) -> Agreement:
    """Of the faithful run with one 2 mm higher."""
    up = np.array([0.0, 0.0, 2e-3])
    raised = replace(faithful, tool_position=faithful.tool_position + up)
    pair = CarriedOut("pybullet", faithful, PASSED), CarriedOut("mujoco", raised, PASSED)
    return compare_runs(plan, scene.robot, *pair)


def scaled(found: Agreement, share: float) -> Agreement:
    """The same with positions nearer to each other."""
    phases = tuple(replace(p, position_mm=share * p.position_mm) for p in found.phases)
    return replace(found, phases=phases)


@pytest.mark.parametrize(("share", "likely"), [(0.4, True), (0.8, False)])
def test_the_change_that_closes_the_gap_is_named(
    agreement: Agreement, share: float, likely: bool
) -> None:
    usual = SimulatorOptions()
    seen = []

    def again(options: SimulatorOptions) -> Agreement:
        seen.append(options)
        return scaled(agreement, share if options.contact_stiffness is None else 1.0)

    found = look_for_cause(agreement, usual, again)
    assert [each.change for each in found.attempts] == list(CHANGES)
    assert len({*seen, usual}) == len(CHANGES) + 1
    assert (found.likely is not None) == likely
    if found.likely is not None:
        assert found.likely.change == "hard contacts"
        assert found.likely.gap is not None
        assert found.likely.gap.ratio == pytest.approx(share * found.gap.ratio)
    json.dumps(found.as_json(), allow_nan=False)


@pytest.fixture
def found(plan: GaitPlan, faithful: RunSeries, agreement: Agreement) -> Comparison:
    planned = planned_at(plan, faithful.time, faithful.fingers)
    one = TrialResult(0, PASSED, METRICS, faithful, planned)
    both = crossed([PASSED, SLIP], [PASSED, PASSED])
    return Comparison(plan_digest(plan), (one, one), agreement, None, both)


def test_a_comparison_is_read_back(plan: GaitPlan, found: Comparison, tmp_path: Path) -> None:
    options = CompareOptions()
    write_comparison(found, plan, options, tmp_path)
    read = read_comparison(tmp_path, plan)
    assert read.found == json.loads(json.dumps(found.as_json()))
    assert [each.simulator for each in read.runs] == list(options.simulators)
    assert all(each.verdict.passed for each in read.runs)
    series = read.runs[0].motion.series
    assert len(series.time) == len(found.nominal[0].series.every(5).time)


@pytest.mark.parametrize(
    "damage",
    [
        lambda told: None,
        lambda told: told | {"schema": "other/1"},
        lambda told: told | {"plan_sha256": "0" * 64},
        lambda told: told | {"nominal": {"simulators": ["../x", "y"]}},
        lambda told: {"schema": told["schema"]},
        lambda told: [told],
    ],
)
def test_a_damaged_comparison_is_refused(
    plan: GaitPlan, found: Comparison, tmp_path: Path, damage: Any
) -> None:
    write_comparison(found, plan, CompareOptions(), tmp_path)
    told = damage(json.loads((tmp_path / FOUND).read_text(encoding="utf-8")))
    if told is None:
        (tmp_path / run_file("mujoco")).unlink()
    else:
        (tmp_path / FOUND).write_text(json.dumps(told), encoding="utf-8")
    with pytest.raises(RecordError) as caught:
        read_comparison(tmp_path, plan)
    assert caught.value.exit_code == 2


def test_both_engines_get_the_same_seeds_and_options(
    monkeypatch: pytest.MonkeyPatch, plan: GaitPlan, faithful: RunSeries
) -> None:
    pytest.importorskip("mujoco")
    planned = planned_at(plan, faithful.time, faithful.fingers)
    asked = []

    def run_trials(_: GaitPlan, seeds: range, options: TrialOptions, **given: Any) -> TrialSet:
        asked.append((list(seeds), options))
        results = []
        for seed in seeds:
            results.append(TrialResult(seed, PASSED, METRICS, faithful, planned))
            given["progress"](results[-1])
        return TrialSet(options, (Stage("x", 1, 1),), tuple(results))

    monkeypatch.setattr(module, "run_trials", run_trials)
    count = []
    options = CompareOptions(trials=3, seed=7, run=RunOptions(controller="admittance"))
    found = compare_engines(plan, options, progress=lambda: count.append(1))
    assert [seeds for seeds, _ in asked] == [[7], [7], [7, 8, 9], [7, 8, 9]]
    assert [o.run.simulator for _, o in asked] == ["pybullet", "mujoco"] * 2
    assert [o.perturbed for _, o in asked] == [False, False, True, True]
    one, two = (replace(o.run, simulator="") for _, o in asked[2:])
    assert one == two
    assert found.agreement.agrees
    assert found.causes is None
    assert found.trials is not None
    assert len(count) == 8


def test_a_missing_engine_is_told_before_work_is_done(
    monkeypatch: pytest.MonkeyPatch, plan: GaitPlan
) -> None:
    monkeypatch.setattr(
        "pivotgait.validation.engine_check.find_spec",
        lambda name: None if name == "mujoco" else name,
    )
    monkeypatch.setattr(module, "run_trials", None)
    with pytest.raises(InputError, match=r"pip install 'pivotgait\[mujoco\]'"):
        compare_engines(plan)


@pytest.mark.parametrize("given", [{"trials": -1}, {"simulators": ("mujoco", "mujoco")}])
def test_bad_options_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        CompareOptions(**given)


def test_unknown_engines_are_told(plan: GaitPlan) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'mujoco'"):
        compare_engines(plan, CompareOptions(simulators=("pybullet", "mujocco")))
