"""Two runs of one plan held against each other, phase by phase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pivotgait.frozen import Array
from pivotgait.models import Robot
from pivotgait.plans import GaitPlan
from pivotgait.validation.agreement import (
    NOT_REACHED,
    PASSED,
    Agreement,
    PhaseAgreement,
    Tolerances,
)
from pivotgait.validation.contact_events import ContactEvent, contact_events
from pivotgait.validation.planned import planned_at
from pivotgait.validation.run_differences import RunDifferences, run_differences
from pivotgait.validation.series import RunSeries
from pivotgait.validation.verdict import Verdict, stage_names

Slips = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class CarriedOut:
    """What a comparison needs of one engine's run.

    Attributes:
        simulator: name.
        series: of the run.
        verdict: of the rule.
    """

    simulator: str
    series: RunSeries
    verdict: Verdict


def compare_runs(
    plan: GaitPlan,
    robot: Robot,
    one: CarriedOut,
    two: CarriedOut,
    *,
    controller: str = "hybrid",
    tolerances: Tolerances | None = None,
) -> Agreement:
    """Compare two runs of one plan under one controller.

    Args:
        plan: that both carried out.
        robot: of the plan.
        one: run in one engine; its rows must be those of the other.
        two: run in another.
        controller: of both.
        tolerances: the default ones if not given.

    Raises:
        InputError: other fingers, other times, or a run that ends before the plan begins.
    """
    tolerances = tolerances or Tolerances()
    apart = run_differences(plan, robot, one.series, two.series)
    within = apart.within(tolerances)
    contacts = [_events(plan, each.series) for each in (one, two)]
    names = stage_names(plan)
    phases = []
    for stage, name in enumerate(names):
        rows = apart.phase == stage
        if not rows.any():
            continue
        said = (_said(one.verdict, stage, names), _said(two.verdict, stage, names))
        pair = (contacts[0].get(name), contacts[1].get(name))
        contact = None if pair[0] is None or pair[1] is None else (pair[0], pair[1])
        phases.append(_phase(name, said, apart, rows, contact, float(np.mean(within[rows]))))
    return Agreement(
        simulators=(one.simulator, two.simulator),
        controller=controller,
        verdicts=(one.verdict, two.verdict),
        tolerances=tolerances,
        phases=tuple(phases),
        share_within=float(np.mean(within)),
    )


def _events(plan: GaitPlan, series: RunSeries) -> Mapping[str, ContactEvent]:
    planned = planned_at(plan, series.followed, series.fingers)
    return {each.phase: each for each in contact_events(plan, series, planned)}


def _said(verdict: Verdict, stage: int, names: tuple[str, ...]) -> str:
    """What a verdict means for one stage; a run that never began reached none."""
    if verdict.passed:
        return PASSED
    failed = names.index(verdict.stage) if verdict.stage else 0
    if stage == failed:
        return verdict.failure
    return PASSED if stage < failed else NOT_REACHED


def _phase(
    name: str,
    verdicts: tuple[str, str],
    apart: RunDifferences,
    rows: NDArray[np.bool_],
    contact: tuple[ContactEvent, ContactEvent] | None,
    share_within: float,
) -> PhaseAgreement:
    forces, slips = {}, {}
    for k, finger in enumerate(apart.fingers):
        wanted = rows & (apart.wanted[:, k] > 0.0)
        if wanted.any():
            forces[finger] = float(np.sqrt(np.mean(apart.normal_force_N[wanted, k] ** 2)))
            slips[finger] = _slips(
                apart.fingertip_slips_mm[wanted, k], apart.fingertip_slip_mm[wanted, k]
            )
    return PhaseAgreement(
        name=name,
        verdicts=verdicts,
        normal_force_rms_N=forces,
        position_mm=float(apart.position_mm[rows].max()),
        orientation_deg=float(apart.orientation_deg[rows].max()),
        tip_slip_mm=_slips(apart.tip_slips_mm[rows], apart.tip_slip_mm[rows]),
        fingertip_slip_mm=slips,
        contact=contact,
        share_within=share_within,
    )


def _slips(each: Array, apart: Array) -> Slips:
    """Largest of both runs (rows, 2), largest difference (rows,)."""
    one, two = each.max(axis=0)
    return float(one), float(two), float(apart.max())
