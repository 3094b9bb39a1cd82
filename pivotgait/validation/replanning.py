"""Re-planning in the loop: after each addition the rest of the gait is planned from measurements.

While the rest is planned, **the grasp is held for a stated simulated time**, the present plan's
last instant; the simulator does not run while the planner does. Wall times of planning are
recorded beside the time of holding, so that a reader sees whether they fit into it. The state is
measured when the hold begins. In its last part the torques of the present law give way to those
of the new one, (1 - s) tau_old + s tau_new with s from 0 to 1 at rest at both ends: both hold the
same grasp, and neither torques nor their rates jump. A rest that cannot be planned is recorded,
and the present plan goes on.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from pivotgait.control.controller import Controller
from pivotgait.control.measurement import Measurement
from pivotgait.control.reference import Reference
from pivotgait.exceptions import InputError, PivotGaitError
from pivotgait.frozen import Array
from pivotgait.gaits import Correction, MeasuredState, continue_gait
from pivotgait.gaits.hand import HandOptions
from pivotgait.models import PhaseConfig, Scene
from pivotgait.plans import ContactTrack, GaitPlan, Phase, RobotMotion, ToolMotion
from pivotgait.validation.planned import Planned

HANDOVER_S = 0.2
"""Last part of a hold, in which the torques of the new plan take over [s]."""
_SAMPLES = 21

LawMaker = Callable[[Reference], Controller]


@dataclass(frozen=True)
class ReplanOptions:
    """When a run plans anew.

    Attributes:
        hold_s: simulated time for which the grasp is held after each addition but the last [s].

    Raises:
        InputError: a hold that is shorter than the handover of torques.
    """

    hold_s: float = 1.0

    def __post_init__(self) -> None:
        if not (isfinite(self.hold_s) and self.hold_s >= HANDOVER_S):
            what, mend = f"{self.hold_s:g} s", f"hold for {HANDOVER_S:g} s or longer"
            raise InputError(what, where="time to hold while planning", mend=mend)


@dataclass(frozen=True)
class Replan:
    """What became of one seam.

    Attributes:
        after: name of the addition before it.
        time_s: since the plan's start [s].
        plan_time_s: wall time of planning and of making the control law [s].
        hold_s: simulated time for which the grasp was held [s].
        correction: from the plan to the measured state; None where planning failed.
        failure: why the old plan went on, empty if it did not.
    """

    after: str
    time_s: float
    plan_time_s: float
    hold_s: float
    correction: Correction | None
    failure: str = ""

    def as_json(self) -> dict[str, Any]:
        """What ``pivotgait validate --replan --json`` prints of it."""
        moved = self.correction
        return {
            "after": self.after,
            "time_s": self.time_s,
            "plan_time_s": self.plan_time_s,
            "hold_s": self.hold_s,
            "replanned": moved is not None,
            "failure": self.failure or None,
            "pivot_mm": None if moved is None else 1e3 * moved.pivot_m,
            "turn_deg": None if moved is None else float(np.degrees(moved.turn_rad)),
            "contacts_mm": (
                {}
                if moved is None
                else {name: 1e3 * each for name, each in moved.contacts_m.items()}
            ),
        }


class Replanning:
    """A control law whose plan is exchanged while it runs; a :class:`Controller`.

    Attributes:
        plan: what was asked for so far and will be, holds included; without closing the fingers.
        seams: what became of each so far.
    """

    def __init__(
        self,
        plan: GaitPlan,
        scene: Scene,
        configs: Sequence[PhaseConfig],
        make_law: LawMaker,
        options: ReplanOptions,
        hand: HandOptions | None = None,
    ) -> None:
        """A law that begins with ``plan``.

        Args:
            plan: with a robot.
            scene: of the plan.
            configs: of its phases.
            make_law: maker of the control law of each plan.
            options: of the holds.
            hand: how its motion is planned.

        Raises:
            InputError: phases that are not those of the plan.
        """
        if [phase.kind for phase in plan.phases] != [config.kind for config in configs]:
            what, mend = "its phases are not those of the gait", "plan the scene again"
            raise InputError(what, where="plan", mend=mend)
        self._scene, self._configs, self._hand = scene, tuple(configs), hand
        self._make_law, self._options = make_law, options
        self._rest = plan.phases
        self.plan = replace(plan, phases=with_holds(plan.phases, options.hold_s))
        self.seams: list[Replan] = []

    def begin(self, reference: Reference) -> Replanning:
        """Take the reference of :attr:`plan`, the closing of the fingers before it included."""
        self._closing_s = reference.duration - _duration(self.plan.phases)
        self._law, self._began_s = self._make_law(reference), 0.0
        self._next: Controller | None = None
        self._next_began_s = 0.0
        self._place, self._hold_began_s = self._next_hold(0)
        return self

    @property
    def duration(self) -> float:
        """Of the whole run as planned now, without the final hold [s]."""
        return self._closing_s + _duration(self.plan.phases)

    @property
    def plan_time_s(self) -> float:
        """Wall time spent on planning so far [s]."""
        return sum(seam.plan_time_s for seam in self.seams)

    def reset(self) -> None:
        """Start anew, before the first cycle of a run."""
        self._law.reset()

    def torque(self, measurement: Measurement) -> Array:
        """(n,) joint torques [N m] or forces [N] of the plan in force, or of two while in turn."""
        time = measurement.time
        if time >= self._hold_began_s:
            self._replan(measurement)
        share = self._share(time)
        if self._next is not None and share >= 1.0:
            self._law, self._began_s, self._next = self._next, self._next_began_s, None
        torque = self._law.torque(measurement._replace(time=time - self._began_s))
        if self._next is None or share <= 0.0:
            return torque
        later = self._next.torque(measurement._replace(time=time - self._next_began_s))
        return (1.0 - share) * torque + share * later

    def _share(self, time: float) -> float:
        """How far the handover has come, from 0 to 1, at rest at both ends."""
        x = min(max((time - self._next_began_s) / HANDOVER_S, 0.0), 1.0)
        return x * x * x * (10.0 + x * (6.0 * x - 15.0))

    def _next_hold(self, start: int) -> tuple[int, float]:
        """Place of the first hold from ``start`` on and when it begins [s]; never without one."""
        phases = self.plan.phases
        for place in range(max(start, 1), len(phases)):
            if phases[place].name == phases[place - 1].name:
                return place, self._closing_s + _duration(phases[:place])
        return len(phases), np.inf

    def _replan(self, measurement: Measurement) -> None:
        """Plan what follows the hold that begins; with success the new law takes over in it."""
        began, place, hold_s = clock.perf_counter(), self._place, self._options.hold_s
        before, held = self.plan.phases[:place], self.plan.phases[place]
        done = next(k for k, each in enumerate(self._rest) if each.name == held.name) + 1
        self._rest = self._rest[done:]
        correction, failure = None, ""
        state = MeasuredState(measurement.q, measurement.tool_position, measurement.tool_rotation)
        rest = replace(self.plan, phases=self._rest)
        try:
            found = continue_gait(rest, self._scene, self._configs, state, options=self._hand)
            taking_over = at_rest(found.plan.phases[0], 0, HANDOVER_S, held.name)
            later = (taking_over, *with_holds(found.plan.phases, hold_s))
            law = self._make_law(Reference.of(replace(rest, phases=later), self._scene.robot))
        except PivotGaitError as error:
            failure = str(error)
            self._place, following_s = self._next_hold(place + 1)
        else:
            law.reset()
            self._next, self._next_began_s = law, self._hold_began_s + hold_s - HANDOVER_S
            self._rest, correction = found.plan.phases, found.correction
            shorter = at_rest(held, 0, hold_s - HANDOVER_S, held.name)
            waiting = (shorter,) if hold_s > HANDOVER_S else ()
            self.plan = replace(self.plan, phases=(*before, *waiting, *later))
            self._place, following_s = self._next_hold(place + len(waiting) + 1)
        spent = clock.perf_counter() - began
        since_start = self._hold_began_s - self._closing_s
        self.seams.append(Replan(held.name, since_start, spent, hold_s, correction, failure))
        self._hold_began_s = following_s


def in_phases_of(plan: GaitPlan, asked: GaitPlan, planned: Planned) -> Planned:
    """What was asked for, counted in the phases of a plan without holds.

    Args:
        plan: of the whole gait.
        asked: the same with holds; names tell which phase of the gait each of its phases is.
        planned: of ``asked``.
    """
    names = [phase.name for phase in plan.phases]
    places = [*(names.index(phase.name) for phase in asked.phases), len(names)]
    return replace(planned, phase=np.array(places, dtype=float)[planned.phase.astype(int)])


def with_holds(phases: Sequence[Phase], hold_s: float) -> tuple[Phase, ...]:
    """The phases, the grasp held after each addition but the last phase.

    A hold bears the name of its addition, so that a run that fails in it failed there.
    """
    found: list[Phase] = []
    for phase in phases:
        found.append(phase)
        if phase.kind == "addition" and phase is not phases[-1]:
            found.append(at_rest(phase, -1, hold_s, phase.name))
    return tuple(found)


def at_rest(phase: Phase, sample: int, duration_s: float, name: str) -> Phase:
    """A sample of a phase for some time: every finger holds with unchanging forces.

    Args:
        phase: with a robot's motion, at rest at the sample.
        sample: its place.
        duration_s: how long [s].
        name: of the phase made.
    """
    motion = phase.robot
    assert motion is not None  # plans of a run have a robot
    tool, still = phase.tool, np.zeros((_SAMPLES, 3))
    moved = np.zeros((_SAMPLES, motion.q.shape[1]))
    return Phase(
        name=name,
        kind="addition",
        finger="",
        time=np.linspace(0.0, duration_s, _SAMPLES),
        tool=ToolMotion(
            position=_repeated(tool.position[sample]),
            orientation=_repeated(tool.orientation[sample]),
            linear_velocity=still,
            angular_velocity=still,
            linear_acceleration=still,
            angular_acceleration=still,
        ),
        contacts={name: _steady(track, sample) for name, track in phase.contacts.items()},
        robot=RobotMotion(
            q=_repeated(motion.q[sample]), v=moved, a=moved, tau=_repeated(motion.tau[sample])
        ),
    )


def _steady(track: ContactTrack, sample: int) -> ContactTrack:
    moment = None if track.moment is None else _repeated(track.moment[sample])
    return replace(track, force=_repeated(track.force[sample]), moment=moment)


def _repeated(row: Array) -> Array:
    return np.repeat(np.asarray(row)[None], _SAMPLES, axis=0)


def _duration(phases: Sequence[Phase]) -> float:
    return sum(phase.duration_s for phase in phases)
