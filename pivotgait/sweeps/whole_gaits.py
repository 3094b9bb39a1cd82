"""``compute: removal``, ``plan`` and ``trials``: cells that are planned one by one."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from pivotgait.certification import certify
from pivotgait.gaits import plan_gait
from pivotgait.gaits.steps import plan_steps
from pivotgait.margins import phase_margins, smallest_margin, smallest_of_phase
from pivotgait.models import RelocationPhase
from pivotgait.phases.grasp import Setting
from pivotgait.plans import GaitPlan
from pivotgait.plans.hdf5_writer import plan_to_bytes
from pivotgait.sweeps.cells import Cell
from pivotgait.sweeps.outcome import Columns, Outcome, Result, attempt
from pivotgait.sweeps.scene_family import SceneFamily
from pivotgait.sweeps.study_config import TrialsConfig
from pivotgait.validation import RunOptions, TrialOptions, run_trial

Results = dict[str, Result]
REMOVAL_COLUMNS: Columns = {
    "feasible": "bool",
    "reorientation_deg": "float",
    "smallest_static_turn_deg": "float",
    "friction_margin": "float",
    "duration_s": "float",
    "iterations": "int",
}
PLAN_COLUMNS: Columns = {
    "feasible": "bool",
    "valid": "bool",
    "reorientation_deg": "float",
    "friction_margin": "float",
    "duration_s": "float",
}
TRIAL_COLUMNS: Columns = {
    **PLAN_COLUMNS,
    "trials": "int",
    "passed": "int",
    "failures": "text",
}


class _OneByOne:
    """Cells that have nothing to do with one another."""

    def outcomes(self, cells: Sequence[Cell]) -> list[Outcome]:
        """Of some cells."""
        return [attempt(self._work(cell)) for cell in cells]

    def _work(self, cell: Cell) -> Callable[[], Results]:
        return lambda: self.compute(cell)

    def compute(self, cell: Cell) -> Results:
        """The columns of one cell.

        Raises:
            PivotGaitError: whatever planning finds.
        """
        raise NotImplementedError


class Removals(_OneByOne):
    """The gait's first removal, after the phases that lead to it; the tool alone, no hand.

    Args:
        family: makes the scenes.
    """

    def __init__(self, family: SceneFamily) -> None:
        self._family = family

    def compute(self, cell: Cell) -> Results:
        """Plan up to the removal and tell of it alone."""
        scene = self._family.scene(cell.values)
        gait = [p for p in scene.gaits["default"] if not isinstance(p, RelocationPhase)]
        phase = plan_steps(Setting.of(scene), gait)[-1].phase
        assert phase is not None  # only relocations have none
        margin = smallest_of_phase(phase_margins(phase), ("friction",))
        return {
            "feasible": True,
            "reorientation_deg": float(phase.reorientation_deg),
            "smallest_static_turn_deg": float(phase.record["smallest_static_turn_deg"]),
            "friction_margin": None if margin is None else margin.value,
            "duration_s": float(phase.duration_s),
            "iterations": int(phase.record["iterations"]),
        }


class Plans(_OneByOne):
    """Whole plans with their certificates.

    Args:
        family: makes the scenes.
        seed: of the planner's searches.
    """

    def __init__(self, family: SceneFamily, seed: int) -> None:
        self._family, self._seed = family, seed

    def plan(self, cell: Cell) -> GaitPlan:
        """The plan of a cell."""
        return plan_gait(self._family.scene(cell.values), gait="default", seed=self._seed)

    def compute(self, cell: Cell) -> Results:
        """Plan, certify, and tell the smallest margin and the largest turn of a removal."""
        return describe(self.plan(cell))


def describe(plan: GaitPlan) -> Results:
    """The columns of a plan."""
    turns = [phase.reorientation_deg for phase in plan.phases if phase.kind == "removal"]
    margin = smallest_margin(plan, ("friction",))
    return {
        "feasible": True,
        "valid": bool(certify(plan).valid),
        "reorientation_deg": float(max(turns, default=0.0)),
        "friction_margin": None if margin is None else margin.value,
        "duration_s": float(sum(phase.duration_s for phase in plan.phases)),
    }


class Trials(_OneByOne):
    """Whole plans carried out in a simulator.

    Args:
        plans: makes the plans.
        config: how many trials, in what.
        seed: of the first trial; each draw goes on from the one before.
        folder: in which the scene's relative URDF paths start.
    """

    def __init__(self, plans: Plans, config: TrialsConfig, seed: int, folder: Path | None) -> None:
        self._plans, self._config, self._seed, self._folder = plans, config, seed, folder
        # Draws of the same values follow one another: one plan serves them all.
        self._last: tuple[tuple[object, ...], GaitPlan, Results] | None = None

    def compute(self, cell: Cell) -> Results:
        """Plan, certify and try; ``failures`` counts them by class, as a JSON object."""
        plan, results = self._planned(cell)
        config = self._config
        options = TrialOptions(
            run=RunOptions(simulator=config.simulator, controller=config.controller),
            perturbed=config.perturbed,
        )
        image, first = plan_to_bytes(plan), self._seed + cell.draw * config.count
        verdicts = [
            run_trial(image, self._folder, seed, options).verdict
            for seed in range(first, first + config.count)
        ]
        failures = Counter(each.failure for each in verdicts if not each.passed)
        return {
            **results,
            "trials": len(verdicts),
            "passed": sum(each.passed for each in verdicts),
            "failures": json.dumps(failures, sort_keys=True),
        }

    def _planned(self, cell: Cell) -> tuple[GaitPlan, Results]:
        key = tuple(cell.values.values())
        if self._last is None or self._last[0] != key:
            plan = self._plans.plan(cell)
            self._last = (key, plan, describe(plan))
        return self._last[1], dict(self._last[2])
