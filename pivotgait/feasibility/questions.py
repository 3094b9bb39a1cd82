"""What a map asks at each of its points: by how much does one grasp of a gait hold?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

import numpy as np

from pivotgait.exceptions import InputError, SceneError, UnknownNameError
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.robustness import friction_drop
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.feasibility.turns import held_at, smallest_tilt
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
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Setting
from pivotgait.phases.lift import LiftOptions, lift_motion
from pivotgait.plans.layout import phase_name

Quantity = Literal["depth", "margin", "turn"]
TURN_MAX_DEG = 60.0


class Answers(NamedTuple):
    """Of a question about n scenes.

    Attributes:
        value: (n,) of the quantity; NaN where no turn is enough.
        feasible: (n,) 1 or 0.
        depth: (n,) of the grasp, least over its moments [N]; NaN for turns.
    """

    value: Array
    feasible: Array
    depth: Array


@dataclass(frozen=True)
class Question:
    """One grasp of a scene's gait, and what is asked about it.

    The grasp is the one a phase ends in, the tool at rest as the gait's lift leaves it; for a lift
    every moment of its motion counts, so that its duration and number of steps matter.

    Attributes:
        gait: of the scene.
        place: of the phase in the gait; no relocation.
        quantity: ``depth``, by how much every limit could be tightened at once [N];
            ``margin``, the share of all friction that could be missing at the weakest moment [-];
            ``turn``, the smallest turn after which the tool is held [deg].
        removed: finger that holds no longer, beside those that the gait has removed.
        turn_max_deg: turns beyond it count as infeasible, for ``turn``.
    """

    gait: str
    place: int
    quantity: Quantity = "depth"
    removed: str = ""
    turn_max_deg: float = TURN_MAX_DEG

    @classmethod
    def about(
        cls,
        scene: Scene,
        *,
        gait: str | None = None,
        phase: str | None = None,
        quantity: str = "depth",
        removed: str = "",
        turn_max_deg: float = TURN_MAX_DEG,
    ) -> Question:
        """The question about a scene.

        Args:
            scene: whose gait.
            gait: its name; the first by default.
            phase: like ``00_lift``; the gait's first removal by default, else its lift.
            quantity: see the attributes.
            removed: likewise.
            turn_max_deg: likewise.

        Raises:
            UnknownNameError: no such gait, phase or quantity; a finger that does not hold then.
            InputError: fewer than two fingers are left; the largest turn is beyond 60 degrees.
        """
        gait = gait or next(iter(scene.gaits))
        if gait not in scene.gaits:
            raise UnknownNameError("gait", gait, scene.gaits, where=f"scene {scene.name}")
        configs = scene.gaits[gait]
        names = {
            phase_name(k, each.kind): k
            for k, each in enumerate(configs)
            if not isinstance(each, RelocationPhase | TransferPhase)
        }
        removals = [name for name in names if isinstance(configs[names[name]], RemovalPhase)]
        phase = phase or next(iter([*removals, *names]))
        if phase not in names:
            raise UnknownNameError("phase", phase, names, where=f"gait {gait}")
        if quantity not in get_args(Quantity):
            raise UnknownNameError("quantity", quantity, get_args(Quantity), where="map")
        if not 0.0 <= turn_max_deg <= TURN_MAX_DEG:
            mend = f"give 0 to {TURN_MAX_DEG:g}"
            raise InputError(f"the largest turn is {turn_max_deg:g} deg", where="map", mend=mend)
        asked = cls(gait, names[phase], quantity, "", turn_max_deg)  # type: ignore[arg-type]
        return asked.without(removed, scene)

    def without(self, finger: str, scene: Scene) -> Question:
        """The same question about the grasp without a finger; an empty name stands for none.

        Raises:
            UnknownNameError: the finger does not hold then.
            InputError: fewer than two fingers are left.
        """
        held = [each.finger for each in replace(self, removed="").fingers(scene)]
        where = phase_name(self.place, scene.gaits[self.gait][self.place].kind)
        if finger and finger not in held:
            raise UnknownNameError("finger", finger, held, where=where)
        if len(held) - bool(finger) < 2:
            what, mend = "one finger alone holds no tool", "remove another finger, or none"
            raise InputError(what, where=where, mend=mend)
        return replace(self, removed=finger)

    def fingers(self, scene: Scene) -> list[HandleContact]:
        """The contacts that hold."""
        held = holding(scene.gaits[self.gait][: self.place + 1], scene)
        return [each for each in held if each.finger != self.removed]

    def grasps(self, scene: Scene) -> Grasps:
        """The grasp at every moment that counts, with the friction that plans may use.

        Raises:
            SceneError: the gait does not begin with a lift.
        """
        config, fingers = scene.gaits[self.gait][self.place], self.fingers(scene)
        lift = _lift(scene, self.gait)
        if config is not lift or self.removed:
            return held_at(scene, fingers, scene.lift_rotation(lift.to))
        setting, target = Setting.of(scene), scene.lift_rotation(lift.to)
        options = LiftOptions(lift.duration_s, lift.steps, lift.profile)
        motion = lift_motion(setting, scene.rest_rotation, target, options)[1]
        return Grasps.of(allocation_problem(setting, motion, fingers))

    def answers(self, scenes: Sequence[Scene]) -> Answers:
        """The answers for n scenes, their grasps solved together.

        Feasible means: with the friction that plans may use, which leaves the scene's reserve out.
        A margin is one of the whole friction.
        """
        if self.quantity == "turn":
            return self._turns(scenes)
        every = [self.grasps(scene) for scene in scenes]
        joined = Grasps.joined(every)
        depth = static_verdicts(joined, exact=True).depth
        first = np.cumsum([0, *(each.count for each in every)]).tolist()
        weakest = np.array([a + int(np.argmin(depth[a:b])) for a, b in pairwise(first)])
        least = depth[weakest]
        feasible = np.where(least >= 0.0, 1.0, 0.0)
        if self.quantity == "depth":
            return Answers(least, feasible, least)
        reserve = np.array([scene.allocation.friction_reserve for scene in scenes])
        held = joined.take(weakest)
        whole = held.changed(friction=held.friction / (1.0 - reserve)[:, None])
        return Answers(friction_drop(whole), feasible, least)

    def _turns(self, scenes: Sequence[Scene]) -> Answers:
        turn = np.full(len(scenes), np.nan)
        largest = np.radians(self.turn_max_deg)
        for k, scene in enumerate(scenes):
            start = scene.lift_rotation(_lift(scene, self.gait).to)
            found = smallest_tilt(scene, self.fingers(scene), start, turn_max_rad=largest)
            if found.feasible:
                turn[k] = np.degrees(found.angle)
        none = np.isnan(turn)
        return Answers(turn, np.where(none, 0.0, 1.0), np.full(len(turn), np.nan))


def holding(configs: Sequence[PhaseConfig], scene: Scene) -> list[HandleContact]:
    """The contacts that hold after some phases of a gait."""
    held: dict[str, HandleContact] = {}
    for config in configs:
        if isinstance(config, LiftPhase):
            held = {scene.contacts[name].finger: scene.contacts[name] for name in config.contacts}
        elif isinstance(config, AdditionPhase):
            held[scene.contacts[config.contact].finger] = scene.contacts[config.contact]
        elif isinstance(config, RemovalPhase):
            held.pop(scene.contacts[config.contact].finger, None)
    return list(held.values())


def _lift(scene: Scene, gait: str) -> LiftPhase:
    for config in scene.gaits[gait]:
        if isinstance(config, LiftPhase):
            return config
    raise SceneError("the gait lifts nothing", where=f"gait {gait}", mend="begin with a lift")
