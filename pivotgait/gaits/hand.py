"""The arm-hand through a whole gait: postures at the key poses, motion in between.

The first posture decides all that follow, since contacts hold from phase to phase. Postures are
therefore sought for every key pose at once, and a candidate counts only when every phase can be
carried out from it: tracked within limits and without collision, relocations found.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from time import perf_counter

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pivotgait.exceptions import InfeasibleError
from pivotgait.frozen import Array
from pivotgait.gaits.itinerary import Itinerary, contacts_left
from pivotgait.gaits.steps import Step
from pivotgait.kinematics import Hold
from pivotgait.models import HandleContact, RelocationPhase, Robot
from pivotgait.phases.carrying import carry
from pivotgait.phases.grasp import Setting
from pivotgait.phases.relocation import relocation_phase, relocation_problem
from pivotgait.phases.tracking import JointMotion, Untracked, Waypoints, track, with_torques
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.posture_chain import PostureChain, Postures, Refused
from pivotgait.planning.posture_search import PostureOptions, PostureSearch, SearchRecord
from pivotgait.planning.problem import RelocationOptions
from pivotgait.planning.relocation import plan_relocation
from pivotgait.plans import Phase

_REST = "the rest of the hand's gait"


@dataclass(frozen=True)
class HandOptions:
    """How the hand's motion is planned.

    Attributes:
        postures: of the search for postures.
        relocation: of the searches for paths; the scene gives their sampling time.
        refinements: most key poses added where a candidate is blocked.
    """

    postures: PostureOptions = field(default_factory=PostureOptions)
    relocation: RelocationOptions = field(default_factory=RelocationOptions)
    refinements: int = 4


@dataclass(frozen=True, eq=False)
class HandGait:
    """A gait with its hand.

    Attributes:
        phases: with robot motion, in order.
        plan_time_s: time spent on each phase's hand, without the search for postures.
        start: itinerary and postures that led to it, from which to plan it again.
        search_time_s: time spent on postures and on candidates that failed.
        record: of the search.
    """

    phases: tuple[Phase, ...]
    plan_time_s: tuple[float, ...]
    start: tuple[Itinerary, Array]
    search_time_s: float
    record: SearchRecord


class Blocked(InfeasibleError):
    """A tracked phase cannot be carried out at a sample between its stops.

    Args:
        place: of the step.
        sample: of its phase.
        q: (nv,) configuration there, as far as it came.
        what: is wrong.
    """

    def __init__(self, place: int, sample: int, q: Array, what: str) -> None:
        self.place, self.sample, self.q = place, sample, q
        super().__init__(what)


class HandPlanner:
    """Plans the arm-hand through the steps of a gait.

    Args:
        setting: tool and table.
        robot: the arm-hand.
        steps: as the tool feels them.
        rng: source of randomness.
        options: how to search.

    Raises:
        SceneError: for an addition to which no relocation brings the finger.
    """

    def __init__(
        self,
        setting: Setting,
        robot: Robot,
        steps: Sequence[Step],
        rng: np.random.Generator,
        options: HandOptions | None = None,
    ) -> None:
        scene = setting.scene
        self._setting, self._robot, self._steps, self._rng = setting, robot, tuple(steps), rng
        self.options = options or HandOptions()
        self.world = CollisionWorld(robot, scene.tool, scene.table.height, scene.clearance)
        self.itinerary = Itinerary.of(scene, self._steps)
        self._left = dict(contacts_left(scene, self._steps))

    def plan(self, like: Sequence[Phase] = ()) -> HandGait:
        """Carry the gait out from the first posture from which it can be.

        Args:
            like: phases of a similar plan with a hand, whose postures are tried first; those that
                the scene suggests come next.

        Raises:
            InfeasibleError: naming what bound most often.
        """
        began, keys = perf_counter(), self.itinerary.keys
        search = PostureSearch(self._robot, self.world, keys, self._rng, self.options.postures)
        for postures in chain(self._known(like), search.candidates()):
            carried = self._refined(postures, self.itinerary)
            if isinstance(carried, str):
                search.record.failures[carried] += 1
                continue
            spent = perf_counter() - began - sum(carried.plan_time_s)
            return replace(carried, search_time_s=spent, record=search.record)
        raise search.record.infeasible("the hand's gait")

    def _known(self, like: Sequence[Phase]) -> Iterator[Postures]:
        """Postures next to those of a similar plan, then to those that the scene suggests."""
        suggested = self.itinerary.postures_suggested(self._steps, self._robot)
        for start in (self.itinerary.postures_in(like) if like else None, suggested):
            settled = None if start is None else self._settle(self.itinerary, start)
            if isinstance(settled, Postures):
                yield settled

    def plan_again(self, found: HandGait) -> HandGait:
        """Carry the gait out once more after its forces have changed, from where it was found.

        Raises:
            InfeasibleError: the hand cannot follow any more.
        """
        began, (itinerary, q) = perf_counter(), found.start
        itinerary = itinerary.renewed(self._steps)
        settled = self._settle(itinerary, q)
        if isinstance(settled, Refused):
            raise InfeasibleError(settled.reason, where="the hand's gait, planned again")
        carried = self._refined(settled, itinerary)
        if isinstance(carried, str):
            raise InfeasibleError(carried, where="the hand's gait, planned again")
        spent = found.search_time_s + perf_counter() - began - sum(carried.plan_time_s)
        return replace(carried, search_time_s=spent, record=found.record)

    def continue_like(self, like: Sequence[Phase], q: Array) -> HandGait:
        """Carry the rest of a gait out from where the hand is, next to how it was planned.

        The key poses' postures are those of the plan, moved by steps of least norm to the contacts
        and tool poses of the steps; only where that does not do are they fitted anew.

        Args:
            like: the plan's phases for the same steps.
            q: (nv,) joint positions now.

        Raises:
            InfeasibleError: the hand cannot follow from there.
        """
        began, itinerary = perf_counter(), self.itinerary
        start = itinerary.postures_in(like)
        start[0] = q
        chain, reasons = self._chain(itinerary), []
        fitted = partial(chain.settle, iterations=self.options.postures.rounds[-1])
        for found in (chain.closed, fitted):
            postures = found(start)
            if isinstance(postures, Refused):
                reasons.append(postures.reason)
                continue
            carried = self._refined(postures, itinerary)
            if isinstance(carried, str):
                reasons.append(carried)
                continue
            spent = perf_counter() - began - sum(carried.plan_time_s)
            return replace(carried, search_time_s=spent)
        raise InfeasibleError("; fitted anew: ".join(reasons), where=_REST)

    def _refined(self, postures: Postures, itinerary: Itinerary) -> HandGait | str:
        """Carry the gait out; where it is blocked between key poses, seek a posture there too."""
        for _ in range(self.options.refinements + 1):
            try:
                return self._carry_out(itinerary, postures)
            except Blocked as blocked:
                reason, step = f"{self._steps[blocked.place].name}: {blocked.what}", blocked.place
                stops = itinerary.stops[step]
                if len(stops) == 1 or any(stop.sample == blocked.sample for stop in stops):
                    return reason
                itinerary, new = itinerary.with_stop(self._steps, step, blocked.sample)
                settled = self._settle(itinerary, np.insert(postures.q, new, blocked.q, axis=0))
                if isinstance(settled, Refused):
                    return f"{reason}; {settled.reason}"
                postures = settled
            except InfeasibleError as error:
                return " ".join((error.where + ":" if error.where else "", error.what)).strip()
        return reason

    def _settle(self, itinerary: Itinerary, start: Array) -> Postures | Refused:
        return self._chain(itinerary).settle(start, self.options.postures.rounds[-1])

    def _chain(self, itinerary: Itinerary) -> PostureChain:
        least = self.options.postures.singular_value_min
        return PostureChain(self._robot, self.world, itinerary.keys, least)

    def _carry_out(self, itinerary: Itinerary, postures: Postures) -> HandGait:
        """The phases with robot motion.

        Raises:
            Blocked: a tracked phase breaks a limit or collides between its stops.
            InfeasibleError: a phase cannot be done otherwise.
        """
        # Relocations last: they take longest and are rarely what fails.
        order = sorted(range(len(self._steps)), key=lambda k: self._steps[k].phase is None)
        done: dict[int, tuple[Phase, float]] = {}
        for k in order:
            began, step, stops = perf_counter(), self._steps[k], itinerary.stops[k]
            q = postures.q[[stop.key for stop in stops]]
            if step.phase is None:
                phase = self._relocate(step, q[0], q[-1], postures)
            else:
                through = Waypoints(np.array([stop.sample for stop in stops]), q)
                phase = self._track(k, step.phase, through, postures)
            done[k] = phase, perf_counter() - began
        phases, times = zip(*(done[k] for k in range(len(self._steps))), strict=True)
        return HandGait(phases, times, (itinerary, postures.q), 0.0, SearchRecord())

    def _track(self, place: int, phase: Phase, through: Waypoints, postures: Postures) -> Phase:
        step = self._steps[place]
        holds = _holds(postures, step.touching.values())
        try:
            if phase.kind == "transfer":
                motion = carry(self._robot, phase.time, phase.tool, through.q[0])
            else:
                motion = track(self._robot, holds, phase.time, phase.tool, through)
        except Untracked as error:
            raise Blocked(place, error.sample, error.q, error.what) from error
        self._check_limits(place, motion)
        self._check_clearance(place, motion, phase, frozenset(step.touching))
        robot = with_torques(self._robot, motion, phase.contacts, phase.tool)
        return replace(phase, robot=robot)

    def _check_limits(self, place: int, motion: JointMotion) -> None:
        robot = self._robot
        beyond = robot.beyond_limits(motion.q)
        if beyond.max() > 0.0:
            sample, joint = divmod(int(np.argmax(beyond)), robot.nv)
            what = f"leaves the limit of {robot.joint_names[joint]}"
            raise Blocked(place, sample, motion.q[sample], what)
        share = np.abs(motion.v) / robot.velocity_max
        if share.max() > 1.0:
            joint = int(np.argmax(share.max(axis=0)))
            raise InfeasibleError(
                f"is too fast for {robot.joint_names[joint]}", where=self._steps[place].name
            )

    def _check_clearance(
        self, place: int, motion: JointMotion, phase: Phase, touching: frozenset[str]
    ) -> None:
        """At every sample and halfway between two, where shapes are a few millimetres on."""
        if np.all(motion.q == motion.q[0]):
            return  # at a key pose, where it was checked
        world, rotation = self.world.holding(touching), phase.tool.rotation
        step = np.diff(phase.time)[:, None]
        halfway = Slerp(phase.time, rotation)(phase.time[:-1] + 0.5 * step[:, 0])
        between = 0.5 * (motion.q[:-1] + motion.q[1:]) - 0.125 * step * np.diff(motion.v, axis=0)
        q = np.concatenate((motion.q, between))
        turns = Rotation.concatenate((rotation, halfway))
        poses = turns.as_matrix(), self._places(phase, turns)
        if all(world.free(*each) for each in zip(q, *poses, strict=True)):
            return
        found = [world.clearance(*each) for each in zip(q, *poses, strict=True)]
        worst = int(np.argmin([distance for distance, _ in found]))
        what = "collision: " + " - ".join(found[worst][1])
        raise Blocked(place, worst % len(motion.q), q[worst], what)

    def _places(self, phase: Phase, turns: Rotation) -> Array:
        """(2 N - 1, 3) where the centre of mass is at the samples and halfway between them [m]."""
        if phase.kind != "transfer":
            return self._setting.scene.centre_of_mass(turns)
        at, speed = phase.tool.position, phase.tool.linear_velocity
        step = np.diff(phase.time)[:, None]
        between = 0.5 * (at[:-1] + at[1:]) - 0.125 * step * np.diff(speed, axis=0)
        return np.concatenate((at, between))

    def _relocate(self, step: Step, start: Array, goal: Array, postures: Postures) -> Phase:
        scene, config, grasp = self._setting.scene, step.config, step.before
        assert isinstance(config, RelocationPhase)
        contact, left = scene.contacts[config.contact], self._left.get(step.name)
        problem = relocation_problem(
            scene,
            self.world,
            grasp.rotation,
            _holds(postures, grasp.fingers.values()),
            contact,
            lands=config.standoff_m == 0.0,
            start=start,
            goal=goal,
            left=left,
            options=replace(self.options.relocation, sample_s=config.sample_s),
        )
        result = plan_relocation(problem, self._rng)
        if result.trajectory is None:
            raise InfeasibleError(result.failure, where=step.name)
        path = result.trajectory
        phase = relocation_phase(self._setting, grasp, contact.finger, path.time, name=step.name)
        motion = JointMotion(path.q, path.v, path.a)
        record = {
            "solver": "RRT",
            "iterations": result.iterations,
            "nodes": sum(result.nodes),
            "length_found_m": result.length_found,
            "length_m": result.length,
        }
        robot = with_torques(self._robot, motion, phase.contacts, phase.tool)
        return replace(phase, robot=robot, record=record)


def _holds(postures: Postures, contacts: Iterable[HandleContact]) -> list[Hold]:
    return [postures.holds[contact.finger, contact.name] for contact in contacts]
