"""A gait's phases as the tool feels them: motion and forces, before any hand is asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from types import MappingProxyType

from pivotgait.exceptions import PivotGaitError
from pivotgait.forces import LinearRows
from pivotgait.models import (
    AdditionPhase,
    HandleContact,
    LiftPhase,
    PhaseConfig,
    RelocationPhase,
    TransferPhase,
)
from pivotgait.phases.addition import AdditionOptions, plan_addition
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.lift import LiftOptions, plan_lift
from pivotgait.phases.removal import RemovalOptions, plan_removal
from pivotgait.phases.removal_problem import RemovalWeights
from pivotgait.phases.transfer import TransferOptions, plan_transfer
from pivotgait.plans import Phase
from pivotgait.plans.layout import phase_name


@dataclass(frozen=True, eq=False)
class Step:
    """One phase of the gait.

    Attributes:
        config: what the scene asks for.
        name: of the phase.
        phase: tool motion and forces; None for a relocation, whose duration the hand decides.
        before: the grasp it starts from.
        after: the grasp it ends in.
        plan_time_s: time it took to plan so far.
    """

    config: PhaseConfig
    name: str
    phase: Phase | None
    before: Grasp
    after: Grasp
    plan_time_s: float

    @property
    def touching(self) -> dict[str, HandleContact]:
        """Finger -> contact of all that touch the tool at any time, in the order they came."""
        return {**self.before.fingers, **self.after.fingers}


def plan_steps(
    setting: Setting,
    configs: Sequence[PhaseConfig],
    done: Callable[[Step, int], None] | None = None,
    rows: Mapping[str, LinearRows] | None = None,
    *,
    start: Grasp | None = None,
    first: int = 0,
) -> tuple[Step, ...]:
    """Plan the tool's motion and forces phase after phase, each from where the last one ended.

    Args:
        setting: tool and table.
        configs: what the scene asks for.
        done: called after each step with its place.
        rows: step's name -> joint torque limits along it, for lifts and additions.
        start: the grasp before the first of them; the tool lies untouched without one.
        first: place of the first of them in the whole gait, for the phases' names.

    Raises:
        InfeasibleError: no forces or no motion satisfy a phase's constraints.
        SolverError: a solver failed otherwise.
    """
    grasp = start or Grasp(setting.scene.rest_rotation, MappingProxyType({}))
    steps: list[Step] = []
    for place, config in enumerate(configs):
        began, name = perf_counter(), phase_name(first + place, config.kind)
        phase, after = _plan(setting, grasp, config, name, (rows or {}).get(name))
        if isinstance(config, LiftPhase):
            grasp = Grasp(grasp.rotation, after.fingers)
        steps.append(Step(config, name, phase, grasp, after, perf_counter() - began))
        if done is not None:
            done(steps[-1], place)
        grasp = after
    return tuple(steps)


def _plan(
    setting: Setting, grasp: Grasp, config: PhaseConfig, name: str, rows: LinearRows | None
) -> tuple[Phase | None, Grasp]:
    scene = setting.scene
    try:
        if isinstance(config, RelocationPhase):
            return None, grasp
        if isinstance(config, LiftPhase):
            touching = [scene.contacts[each] for each in config.contacts]
            start = Grasp(grasp.rotation, {contact.finger: contact for contact in touching})
            lift = LiftOptions(config.duration_s, config.steps, config.profile)
            target = scene.lift_rotation(config.to)
            return plan_lift(setting, start, target, lift, name=name, rows=rows)
        if isinstance(config, TransferPhase):
            transfer = TransferOptions(config.duration_s, config.steps, config.rise_m)
            return plan_transfer(setting, grasp, transfer, name=name)
        contact = scene.contacts[config.contact]
        if isinstance(config, AdditionPhase):
            addition = AdditionOptions(config.duration_s, config.steps)
            return plan_addition(setting, grasp, contact, addition, name=name, rows=rows)
        removal = RemovalOptions(
            config.duration_s,
            config.steps,
            RemovalWeights(**config.weights.model_dump()),
            doubling=config.doubling,
        )
        return plan_removal(setting, grasp, contact.finger, removal, name=name)
    except PivotGaitError as error:
        if name in error.where:
            raise
        where = f"{name} {error.where}".strip()
        raise type(error)(error.what, where=where, mend=error.mend) from error
