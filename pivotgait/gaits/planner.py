"""Plan the phases of a gait one after the other, each from where the last one ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from time import perf_counter
from types import MappingProxyType

from pivotgait import __version__
from pivotgait.exceptions import InputError, PivotGaitError, UnknownNameError
from pivotgait.models import AdditionPhase, LiftPhase, RemovalPhase, Scene
from pivotgait.phases.addition import AdditionOptions, plan_addition
from pivotgait.phases.grasp import Grasp, Setting
from pivotgait.phases.lift import LiftOptions, plan_lift
from pivotgait.phases.removal import RemovalOptions, plan_removal
from pivotgait.phases.removal_problem import RemovalWeights
from pivotgait.plans import GaitPlan, Phase, PlannedTool

PhaseConfig = LiftPhase | AdditionPhase | RemovalPhase

PACKAGES = ("numpy", "scipy", "pin", "coal", "clarabel", "casadi")
"""Packages whose versions a plan carries: those its numbers depend on."""


@dataclass(frozen=True)
class PhaseDone:
    """News of the planner's progress: a phase, its place, their number, its time of planning."""

    phase: Phase
    place: int
    count: int
    plan_time_s: float


def plan_gait(
    scene: Scene,
    *,
    gait: str | None = None,
    seed: int = 0,
    progress: Callable[[PhaseDone], None] | None = None,
) -> GaitPlan:
    """Plan every phase of a gait.

    Args:
        scene: tool, table, contacts and gaits.
        gait: which of the scene's gaits; the first without it.
        seed: of the random generator. The force-level planners draw no random numbers; it is
            kept in the plan for those that do.
        progress: called after each phase.

    Returns:
        The plan, without a certificate.

    Raises:
        UnknownNameError: no such gait.
        InputError: a negative seed.
        InfeasibleError: no forces or no motion satisfy a phase's constraints.
        SolverError: a solver failed otherwise.
    """
    if seed < 0:
        raise InputError(f"seed {seed} is negative", where="seed", mend="give 0 or more")
    if gait is not None and gait not in scene.gaits:
        raise UnknownNameError("gait", gait, scene.gaits, where=f"scene {scene.name}")
    configs = scene.gaits[gait or next(iter(scene.gaits))]
    setting = Setting.of(scene)
    grasp = Grasp(scene.rest_rotation, MappingProxyType({}))
    phases: list[Phase] = []
    for place, config in enumerate(configs):
        began, name = perf_counter(), f"{place:02d}_{config.kind}"
        phase, grasp = _plan_phase(setting, grasp, config, name)
        phases.append(phase)
        if progress is not None:
            progress(PhaseDone(phase, place, len(configs), perf_counter() - began))
    tool = scene.tool
    return GaitPlan(
        scene=scene.yaml,
        seed=seed,
        versions={"pivotgait": __version__, **{name: version(name) for name in PACKAGES}},
        gravity=scene.gravity,
        table_height=scene.table.height,
        tool=PlannedTool(
            name=tool.name,
            mass=tool.mass,
            inertia=tool.inertia,
            pivot_in_tool=tool.pivot_in_tool,
            urdf=tool.urdf,
            centre_of_mass_in_root=tool.centre_of_mass_in_root,
        ),
        phases=tuple(phases),
    )


def _plan_phase(
    setting: Setting, grasp: Grasp, config: PhaseConfig, name: str
) -> tuple[Phase, Grasp]:
    scene = setting.scene
    try:
        if isinstance(config, LiftPhase):
            touching = [scene.contacts[each] for each in config.contacts]
            start = Grasp(grasp.rotation, {contact.finger: contact for contact in touching})
            lift = LiftOptions(config.duration_s, config.steps, config.profile)
            return plan_lift(setting, start, scene.lift_rotation(config.to), lift, name=name)
        contact = scene.contacts[config.contact]
        if isinstance(config, AdditionPhase):
            addition = AdditionOptions(config.duration_s, config.steps)
            return plan_addition(setting, grasp, contact, addition, name=name)
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
