"""The nearest changes of a scene with which its gait becomes feasible, each tried out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pivotgait.exceptions import PivotGaitError
from pivotgait.feasibility.changes import Variants
from pivotgait.feasibility.grasps import Grasps
from pivotgait.feasibility.mend_lines import TURN_MAX, Line, SceneMend, mend_lines
from pivotgait.feasibility.rehearsal import Obstacle, Rehearsal, rehearse
from pivotgait.feasibility.static_verdicts import static_verdicts
from pivotgait.feasibility.turns import held_at, smallest_tilt
from pivotgait.models import LiftPhase, RemovalPhase, Scene, TransferPhase
from pivotgait.models.parameters import Value
from pivotgait.phases.allocation import allocation_problem
from pivotgait.phases.grasp import Setting
from pivotgait.phases.lift import LiftOptions, lift_motion

SCAN = 16
"""Values tried outwards along a line on which feasibility may come and go."""
HALVINGS = 10
TRIALS = 10
"""Most mends tried out."""
CHASES = 4
"""Times a change is pushed further because another phase fails with it."""


@dataclass(frozen=True, eq=False)
class MendSearch:
    """What the search for mends works on.

    Attributes:
        variants: of the scene before any change.
        gait: which of its gaits.
        changes: made to the scene already, on top of which the mends come.
        turn_max_deg: see :func:`rehearse`.
    """

    variants: Variants
    gait: str
    changes: Mapping[str, Value] = field(default_factory=dict)
    turn_max_deg: float | None = None

    def scene(self, more: Mapping[str, Value] | None = None) -> Scene:
        """The scene after the changes made already, and more of them.

        Raises:
            PivotGaitError: see :meth:`Variants.scene_with`.
        """
        more = more or {}
        before = {path: value for path, value in self.changes.items() if path not in more}
        return self.variants.scene_with({**before, **more})

    def find(
        self,
        rehearsal: Rehearsal,
        count: int = 3,
        tell: Callable[[str], None] = lambda text: None,
    ) -> tuple[SceneMend, ...]:
        """The nearest mends of a rehearsal's obstacle, each by a change of its own.

        Every candidate is followed until the obstacle gives way: by bisection where more of it
        always helps, else by a scan outwards with bisection in its first gap. Then the whole gait
        is gone through with it, the smallest changes first; where another phase fails, the change
        is pushed further. What remains infeasible is not offered.

        Args:
            rehearsal: with an obstacle.
            count: most mends.
            tell: called with each parameter that is looked at.
        """
        obstacle = rehearsal.obstacle
        if obstacle is None:
            return ()
        every = tuple(
            mend_lines(self.scene(), self.gait, obstacle, self.changes, self.turn_max_deg)
        )
        found: list[SceneMend] = []
        for line in every:
            tell(line.path)
            value = self._crossing(line, obstacle)
            if value is not None:
                found.append(line.mend(value))
        lines = {(line.path, line.far > line.now): line for line in every}
        kept: list[SceneMend] = []
        for mend in sorted(found, key=lambda each: each.size)[:TRIALS]:
            tell(f"{mend.change} = {mend.to:g}")
            line = lines[mend.change, mend.to > mend.from_]
            try:
                tried = self._tried_out(line, mend, obstacle.place)
            except PivotGaitError:
                tried = None  # no scene, or a solver that gives up on it
            if tried is not None and tried.change not in {each.change for each in kept}:
                kept.append(tried)
            if len(kept) == count:
                break
        return tuple(sorted(kept, key=lambda each: each.size))

    def _tried_out(self, line: Line, mend: SceneMend, place: int) -> SceneMend | None:
        """The mend of the phase at ``place``, pushed until nothing is left; None if it never is."""
        for _ in range(CHASES):
            obstacle = self._rehearsed({line.path: mend.to})
            if obstacle is None:
                return mend
            rest = Line(line.path, mend.to, line.far, line.unit, line.steady)
            # what the quick judgement of this phase did not see, the whole of it will
            value = self._crossing(rest, obstacle, thorough=obstacle.place == place)
            if value is None:
                return None
            mend = line.mend(value)
        return None

    def _rehearsed(self, changes: Mapping[str, Value], last: int | None = None) -> Obstacle | None:
        """The obstacle that remains after changes, in the phases up to place ``last``."""
        turn = changes.get(TURN_MAX, self.turn_max_deg)
        scene = self.scene({path: value for path, value in changes.items() if path != TURN_MAX})
        configs = scene.gaits[self.gait]
        limit = None if turn is None else float(turn)
        until = len(configs) if last is None else last + 1
        return rehearse(scene, configs[:until], turn_max_deg=limit).obstacle

    def _crossing(self, line: Line, obstacle: Obstacle, *, thorough: bool = False) -> float | None:
        """The first value along a line at which the obstacle gives way, rounded; None if none."""
        judge = self._beyond if thorough else self._passes

        def passes(value: float) -> bool:
            try:
                return judge({line.path: line.mend(value).to}, obstacle)
            except PivotGaitError:
                return False  # no such scene: a place off the handle, a lift into the table

        low, high = line.now, line.far
        if obstacle.kind == "turn":
            return high  # the turn that was made
        if line.steady:
            if not passes(high):
                return None
        else:
            values = np.linspace(line.now, line.far, SCAN + 1)[1:].tolist()
            first = next((k for k, value in enumerate(values) if passes(value)), None)
            if first is None:
                return None
            low, high = (line.now, *values)[first], values[first]
        for _ in range(HALVINGS):
            geometric = line.steady and low > 0.0 and high > 0.0
            middle = float(np.sqrt(low * high)) if geometric else 0.5 * (low + high)
            low, high = (low, middle) if passes(middle) else (middle, high)
        return high

    def _passes(self, changes: Mapping[str, Value], obstacle: Obstacle) -> bool:
        """Whether the obstacle's phase has forces: at rest, or for a lift along its motion."""
        if obstacle.kind in ("turn", "force_rate", "motion"):
            return self._beyond(changes, obstacle)
        scene = self.scene(changes)
        configs = scene.gaits[self.gait]
        config = configs[obstacle.place]
        if isinstance(config, TransferPhase):
            return self._beyond(changes, obstacle)
        if isinstance(config, LiftPhase):
            return bool(static_verdicts(_lifted(scene, config)).feasible.all())
        fingers = [scene.contacts[each.name] for each in obstacle.before.fingers.values()]
        lift, earlier = configs[0], configs[: obstacle.place]
        rotation = obstacle.before.rotation
        if isinstance(lift, LiftPhase) and not any(isinstance(e, RemovalPhase) for e in earlier):
            rotation = scene.lift_rotation(lift.to)
        contact = scene.contacts[config.contact]
        if isinstance(config, RemovalPhase):
            staying = [each for each in fingers if each.finger != contact.finger]
            return smallest_tilt(scene, staying, rotation, coarse=True).feasible
        held = held_at(scene, [*fingers, contact], rotation)
        return bool(static_verdicts(held).feasible.all())

    def _beyond(self, changes: Mapping[str, Value], obstacle: Obstacle) -> bool:
        """Whether no obstacle remains up to the phase of this one."""
        return self._rehearsed(changes, obstacle.place) is None


def _lifted(scene: Scene, config: LiftPhase) -> Grasps:
    """Every moment of a lift."""
    setting, target = Setting.of(scene), scene.lift_rotation(config.to)
    options = LiftOptions(config.duration_s, config.steps, config.profile)
    motion = lift_motion(setting, scene.rest_rotation, target, options)[1]
    fingers = [scene.contacts[name] for name in config.contacts]
    return Grasps.of(allocation_problem(setting, motion, fingers))
