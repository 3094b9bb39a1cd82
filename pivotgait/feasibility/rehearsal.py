"""A gait gone through without a hand: its phases, and the first obstacle if there is one.

Feasibility is proven by construction: forces along every lift, addition and transfer, and for a
removal a smooth turn to the nearest orientation that the others can hold. Where that turn is not
enough the planner's own trajectory optimisation is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from pivotgait.exceptions import InfeasibleError, PivotGaitError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.feasibility.tightest import tightest_limit
from pivotgait.feasibility.turns import TURN_MAX_RAD, Turn, held_at, smallest_tilt
from pivotgait.forces import allocate
from pivotgait.frozen import Array
from pivotgait.models import (
    AdditionPhase,
    HandleContact,
    LiftPhase,
    PhaseConfig,
    RelocationPhase,
    RemovalPhase,
    Scene,
    TransferPhase,
)
from pivotgait.phases.addition import AdditionOptions, plan_addition
from pivotgait.phases.allocation import allocate_smoothly, allocation_problem
from pivotgait.phases.grasp import Grasp, Setting, finger_track
from pivotgait.phases.lift import LiftOptions, lift_motion, plan_lift
from pivotgait.phases.relocation import resting_tool
from pivotgait.phases.removal import RemovalOptions, plan_removal
from pivotgait.phases.removal_problem import RemovalWeights
from pivotgait.phases.transfer import TransferOptions, plan_transfer
from pivotgait.plans import PIVOT, Phase
from pivotgait.plans.layout import phase_name


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Why a phase cannot be done.

    Attributes:
        place: of the phase among the gait's configs.
        phase: its name.
        config: what the scene asks for.
        before: the grasp it starts from.
        kind: the limit that binds: ``friction``, ``normal_max``, ``normal_min``, ``wrench`` (no
            forces of any size do), ``force_rate``, ``turn`` (the tool may not turn as far as it
            would have to) or ``motion`` (no trajectory was found, or no forces off the table).
        contact: whose limit, a finger or ``pivot``; empty where it is nobody's.
        time_s: from the phase's start [s].
        text: one sentence.
        needed: for ``turn`` the degrees, for ``force_rate`` the seconds that suffice; else 0.
        grasp: the one that cannot be held, with the friction that plans may use; None for kinds
            other than limits of contacts.
    """

    place: int
    phase: str
    config: PhaseConfig
    before: Grasp
    kind: str
    contact: str
    time_s: float
    text: str
    needed: float = 0.0
    grasp: Grasps | None = None


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """What came of it.

    Attributes:
        phases: those that can be done, in order, without relocations.
        obstacle: at the next one, None if all can be done.
    """

    phases: tuple[Phase, ...]
    obstacle: Obstacle | None


class _Blocked(Exception):
    """A phase cannot be done; carries the fields of the obstacle."""

    def __init__(
        self,
        kind: str,
        contact: str,
        time_s: float,
        text: str,
        needed: float = 0.0,
        grasp: Grasps | None = None,
    ) -> None:
        self.fields = (kind, contact, time_s, text, needed, grasp)
        super().__init__(text)


def rehearse(
    scene: Scene,
    configs: Sequence[PhaseConfig],
    *,
    turn_max_deg: float | None = None,
    done: Callable[[Phase], None] | None = None,
) -> Rehearsal:
    """Go through a gait's phases as the tool feels them, up to the first that cannot be done.

    Args:
        scene: tool, table, contacts. Forces minimise |f_t|^2 / f_n, whatever objective the scene
            names: whether there are any does not depend on it.
        configs: what the scene asks for; relocations leave the tool alone and pass.
        turn_max_deg: largest angle by which a removal may turn the tool [deg]; None for any up to
            60 degrees, 0 for no pivoting.
        done: called after each phase.
    """
    allocation = scene.allocation.model_copy(update={"objective": "tangential"})
    config = scene.config.model_copy(update={"allocation": allocation})
    setting = Setting.of(replace(scene, config=config))
    grasp = Grasp(scene.rest_rotation, MappingProxyType({}))
    phases: list[Phase] = []
    for place, each in enumerate(configs):
        name = phase_name(place, each.kind)
        try:
            if isinstance(each, RelocationPhase):
                continue
            if isinstance(each, LiftPhase):
                phase, after = _lift(setting, grasp, each, name)
                grasp = Grasp(grasp.rotation, after.fingers)
            elif isinstance(each, AdditionPhase):
                phase, after = _addition(setting, grasp, each, name)
            elif isinstance(each, TransferPhase):
                phase, after = _transfer(setting, grasp, each, name)
            else:
                phase, after = _removal(setting, grasp, each, name, turn_max_deg)
        except _Blocked as blocked:
            return Rehearsal(tuple(phases), Obstacle(place, name, each, grasp, *blocked.fields))
        phases.append(phase)
        grasp = after
        if done is not None:
            done(phase)
    return Rehearsal(tuple(phases), None)


def _lift(setting: Setting, grasp: Grasp, config: LiftPhase, name: str) -> tuple[Phase, Grasp]:
    scene, options = setting.scene, LiftOptions(config.duration_s, config.steps, config.profile)
    touching = [scene.contacts[each] for each in config.contacts]
    start = Grasp(grasp.rotation, {contact.finger: contact for contact in touching})
    target = scene.lift_rotation(config.to)
    time, motion = lift_motion(setting, grasp.rotation, target, options)
    _require_forces(Grasps.of(allocation_problem(setting, motion, touching)), time)
    try:
        return plan_lift(setting, start, target, options, name=name)
    except InfeasibleError as error:
        raise _Blocked("force_rate", "", 0.0, error.what) from error


def _addition(
    setting: Setting, grasp: Grasp, config: AdditionPhase, name: str
) -> tuple[Phase, Grasp]:
    contact = setting.scene.contacts[config.contact]
    options = AdditionOptions(config.duration_s, config.steps)
    fingers = [*grasp.fingers.values(), contact]
    problem = allocation_problem(setting, resting_tool(setting, grasp.rotation, 1), fingers)
    _require_forces(Grasps.of(problem), np.array([config.duration_s]))
    try:
        return plan_addition(setting, grasp, contact, options, name=name)
    except InfeasibleError as error:
        held = np.stack([grasp.forces[each] for each in problem.names if each in grasp.forces])
        change = allocate(problem).force[0] - np.vstack((held, np.zeros(3)))
        needed = np.linalg.norm(change, axis=1).max() / scene_rate(setting.scene)
        raise _Blocked("force_rate", contact.finger, 0.0, error.what, float(needed)) from error


def _transfer(
    setting: Setting, grasp: Grasp, config: TransferPhase, name: str
) -> tuple[Phase, Grasp]:
    options = TransferOptions(config.duration_s, config.steps, config.rise_m)
    try:
        return plan_transfer(setting, grasp, options, name=name)
    except InfeasibleError as error:
        raise _Blocked("motion", "", 0.0, error.what) from error


def _require_forces(grasps: Grasps, time: Array) -> None:
    """Every sample, alone, must have forces.

    Raises:
        _Blocked: with what binds at the first sample that has none.
    """
    alone = static_verdicts(grasps).feasible
    if alone.all():
        return
    sample = int(np.argmin(alone))
    grasp = grasps.take(np.array([sample]))
    found = tightest_limit(grasp)
    lost = int((~alone).sum())
    text = f"{lost} of {len(alone)} moments have no forces ({-found.depth:.3g} N short)"
    raise _Blocked(found.kind, found.contact, float(time[sample]), text, grasp=grasp)


def scene_rate(scene: Scene) -> float:
    """Bound of the change of a contact force [N/s]."""
    return scene.allocation.force_rate_max_N_s


def _removal(
    setting: Setting, grasp: Grasp, config: RemovalPhase, name: str, turn_max_deg: float | None
) -> tuple[Phase, Grasp]:
    scene, end = setting.scene, config.duration_s
    leaving = scene.contacts[config.contact]
    staying = [contact for each, contact in grasp.fingers.items() if each != leaving.finger]
    need = smallest_tilt(scene, staying, grasp.rotation)
    if not need.feasible:
        held = held_at(scene, staying, need.rotation)
        found = tightest_limit(held)
        text = f"without {leaving.finger} no orientation within "
        text += f"{np.degrees(TURN_MAX_RAD):.0f} deg can be held ({-need.depth:.3g} N short)"
        raise _Blocked(found.kind, found.contact, end, text, grasp=held)
    result = turning_removal(setting, grasp, staying, leaving, config, name, need)
    if result is None:
        options = RemovalOptions(
            end,
            config.steps,
            RemovalWeights(**config.weights.model_dump()),
            doubling=config.doubling,
        )
        try:
            result = plan_removal(setting, grasp, leaving.finger, options, name=name)
        except PivotGaitError as error:
            raise _Blocked("motion", leaving.finger, end, error.what) from error
    turned = result[0].reorientation_deg
    if turn_max_deg is not None and turned > turn_max_deg:
        text = f"without {leaving.finger} the tool has to turn by {turned:.2f} deg"
        raise _Blocked("turn", leaving.finger, end, text, turned)
    return result


def turning_removal(
    setting: Setting,
    grasp: Grasp,
    staying: Sequence[HandleContact],
    leaving: HandleContact,
    config: RemovalPhase,
    name: str,
    need: Turn,
) -> tuple[Phase, Grasp] | None:
    """A removal along a quintic turn to an orientation that the others hold.

    Every sample keeps eqs (3), (5), (6), the ramp (7), the rate of forces and the clearance.

    Returns:
        The phase and the grasp it ends in, or None where this motion does not do.
    """
    options = LiftOptions(config.duration_s, config.steps)
    time, motion = lift_motion(setting, grasp.rotation, need.rotation, options)
    if np.min(setting.scene.height(motion.rotation)) < setting.scene.clearance:
        return None
    fingers = [*staying, leaving]
    held = np.stack([grasp.forces[each] for each in (PIVOT, *(f.finger for f in fingers))])
    pressing = float(held[-1] @ (grasp.rotation.as_matrix() @ leaving.normal))
    ramp = {leaving.finger: pressing * np.linspace(1.0, 0.0, len(time))}
    try:
        forces = allocate_smoothly(
            allocation_problem(setting, motion, fingers, ramp=ramp),
            step_s=config.duration_s / config.steps,
            rate_max=scene_rate(setting.scene),
            start=held,
        ).force
    except PivotGaitError:
        return None
    contacts = {PIVOT: setting.pivot_track(forces[:, 0])}
    for place, each in enumerate(fingers, start=1):
        contacts[each.finger] = finger_track(each, forces[:, place], changing=each is leaving)
    record: Mapping[str, object] = {"solver": "turn", "smallest_tilt_deg": np.degrees(need.angle)}
    phase = Phase(name, "removal", leaving.finger, time, motion, contacts, record=record)
    return phase, Grasp.after(motion, {each.finger: each for each in staying}, contacts)
