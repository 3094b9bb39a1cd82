"""The verdict on a scene's gait: feasible or not, what binds, what mends it, by how much."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pivotgait.exceptions import InfeasibleError, InputError, UnknownNameError
from pivotgait.feasibility.carried import carried_moments
from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.gait_margins import GaitMargins, gait_margins
from pivotgait.feasibility.mend_lines import SceneMend
from pivotgait.feasibility.mends import MendSearch
from pivotgait.feasibility.moments import Moments, moments_of
from pivotgait.feasibility.rehearsal import Obstacle, Rehearsal, rehearse
from pivotgait.feasibility.wrench_ball import tool_length
from pivotgait.margins import Margin, largest_share, phase_margins, smallest_of_phase
from pivotgait.margins.smallest import MarginKind
from pivotgait.models import Scene
from pivotgait.models.parameters import Value
from pivotgait.phases.grasp import Setting
from pivotgait.plans import GaitPlan, Phase

Tell = Callable[[str], None]


@dataclass(frozen=True)
class VerdictOptions:
    """What is asked.

    Attributes:
        gait: which of the scene's gaits; None for the first.
        turn_max_deg: largest angle by which a removal may turn the tool; None for no limit.
        hand: whether to plan the arm-hand too and keep its joints' torque limits.
        mends: most mends sought for an infeasible gait.
        volume: whether to measure the volume of the wrenches too.
        seed: of the hand's searches and of the volume's rays.
    """

    gait: str | None = None
    turn_max_deg: float | None = None
    hand: bool = False
    mends: int = 3
    volume: bool = True
    seed: int = 0


@dataclass(frozen=True)
class Binding:
    """What comes first: the limit that is broken, or the smallest margin of a feasible gait.

    Attributes:
        kind: see :class:`Obstacle`; for a feasible gait ``friction`` or ``lift_off``; with a hand
            also ``torque`` or ``hand``.
        contact: finger, ``pivot`` or joint; may be empty.
        phase: its name.
        time_s: from the phase's start [s].
        text: one sentence.
    """

    kind: str
    contact: str
    phase: str
    time_s: float
    text: str

    def as_json(self) -> dict[str, Any]:
        """Plain data for the command line."""
        return dict(vars(self))


@dataclass(frozen=True, eq=False)
class Verdict:
    """The answer.

    Attributes:
        feasible: whether every phase can be done.
        binding: what binds, or comes nearest to it.
        mends: changes that make it feasible, nearest first, each tried out; none if it is.
        margins: of the phases up to the obstacle, and of the grasp that cannot be held.
        phases: that can be done.
    """

    feasible: bool
    binding: Binding
    mends: tuple[SceneMend, ...]
    margins: GaitMargins
    phases: tuple[Phase, ...] = field(default=())

    def as_json(self) -> dict[str, Any]:
        """What ``pivotgait feasibility --json`` prints."""
        return {
            "feasible": self.feasible,
            "binding": self.binding.as_json(),
            "mends": [mend.as_json() for mend in self.mends],
            "margins": self.margins.as_json(),
        }


def judge(
    variants: Variants,
    options: VerdictOptions | None = None,
    *,
    changes: Mapping[str, Value] | None = None,
    tell: Tell = lambda text: None,
) -> Verdict:
    """Judge a scene's gait.

    Args:
        variants: of the scene.
        options: what is asked.
        changes: to the scene; mends come on top of them.
        tell: called with each step of the work.

    Raises:
        InputError: an unknown gait, a limit that is no angle, changes that make no scene.
    """
    options = options or VerdictOptions()
    limit = options.turn_max_deg
    if limit is not None and not 0.0 <= limit <= 180.0:
        what, mend = f"the largest turn is {limit:g} deg", "give 0 to 180"
        raise InputError(what, where="--turn-max", mend=mend)
    scene = variants.scene_with(changes or {})
    gait = options.gait or next(iter(scene.gaits))
    if gait not in scene.gaits:
        raise UnknownNameError("gait", gait, scene.gaits, where=f"scene {scene.name}")
    tell("forces of every phase")
    found = rehearse(scene, scene.gaits[gait], turn_max_deg=limit)
    if found.obstacle is None and options.hand and scene.robot is not None:
        return _with_hand(variants, gait, changes or {}, found, options, tell)
    mends: tuple[SceneMend, ...] = ()
    if found.obstacle is not None and options.mends > 0:
        search = MendSearch(variants, gait, changes or {}, limit)
        mends = search.find(found, options.mends, tell)
    tell("margins")
    return _assembled(scene, found, mends, options)


def _with_hand(
    variants: Variants,
    gait: str,
    changes: Mapping[str, Value],
    found: Rehearsal,
    options: VerdictOptions,
    tell: Tell,
) -> Verdict:
    from pivotgait.gaits import plan_gait  # loads the planners of the hand

    scene = variants.scene_with(changes)
    tell("the hand's motion")
    try:
        plan = plan_gait(scene, gait=gait, seed=options.seed)
    except InfeasibleError as error:
        verdict = _assembled(scene, found, (), options)
        kind = "torque" if "torque" in error.what else "hand"
        binding = Binding(kind, "", error.where, 0.0, str(error))
        verdict = replace(verdict, feasible=False, binding=binding)
        weak = kind == "torque" and options.mends > 0
        return _mended(verdict, variants, gait, changes, options, tell) if weak else verdict
    tell("margins")
    return _assembled(scene, replace(found, phases=plan.phases), (), options, plan)


def _mended(
    verdict: Verdict,
    variants: Variants,
    gait: str,
    changes: Mapping[str, Value],
    options: VerdictOptions,
    tell: Tell,
) -> Verdict:
    """A verdict on joints that are too weak, with the one that binds and what mends it."""
    from pivotgait.feasibility.torque_mends import torque_need

    need = torque_need(variants, gait, changes, options.seed, tell)
    if need is None:
        return verdict
    share, text = need.share, verdict.binding.text
    binding = Binding("torque", share.joint, share.phase, share.time_s, text)
    return replace(verdict, binding=binding, mends=(need.mend,))


def _assembled(
    scene: Scene,
    found: Rehearsal,
    mends: tuple[SceneMend, ...],
    options: VerdictOptions,
    plan: GaitPlan | None = None,
) -> Verdict:
    body, robot = Setting.of(scene).body, scene.robot if plan is not None else None
    on_table = [phase for phase in found.phases if phase.kind != "transfer"]
    moments = [moments_of(phase, body, robot) for phase in on_table]
    off_it = [phase for phase in found.phases if phase.kind == "transfer"]
    obstacle = found.obstacle
    if obstacle is not None and obstacle.grasp is not None:
        whole = obstacle.grasp.friction / (1.0 - scene.allocation.friction_reserve)
        grasp = obstacle.grasp.changed(friction=whole)
        moments.append(Moments(obstacle.phase, np.array([obstacle.time_s]), grasp))
    margins = gait_margins(
        moments,
        tool_length(scene.tool.pivot_in_tool),
        friction=_least(found.phases, "friction"),
        lift_off=_least(found.phases, "lift_off"),
        torque=None if plan is None else largest_share(plan, "torque"),
        volume_rng=np.random.default_rng(options.seed) if options.volume else None,
        carried=[carried_moments(phase, body) for phase in off_it],
    )
    return Verdict(obstacle is None, _binding(obstacle, margins), mends, margins, found.phases)


def _least(phases: tuple[Phase, ...], kind: MarginKind) -> Margin | None:
    every = (smallest_of_phase(phase_margins(phase), (kind,)) for phase in phases)
    return min((each for each in every if each), key=lambda each: each.value, default=None)


def _binding(obstacle: Obstacle | None, margins: GaitMargins) -> Binding:
    if obstacle is not None:
        place = obstacle.phase, obstacle.time_s
        return Binding(obstacle.kind, obstacle.contact, *place, obstacle.text)
    known = [each for each in (margins.friction, margins.lift_off) if each is not None]
    least = min(known, key=lambda each: each.value)
    text = f"smallest margin {least.value:.3f}: {least.kind.replace('_', ' ')} of {least.contact}"
    share = margins.torque
    if share is not None and 1.0 - share.value < least.value:
        text = f"smallest margin {1.0 - share.value:.3f}: torque of {share.joint}"
        return Binding("torque", share.joint, share.phase, share.time_s, text)
    return Binding(least.kind, least.contact, least.phase, least.time_s, text)
