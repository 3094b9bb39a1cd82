"""The arm-hand through a whole gait: postures at the key poses, motion in between.

The first posture decides all that follow, since contacts hold from phase to phase. Postures are
therefore sought for every key pose at once, and a candidate counts only when every phase can be
carried out from it: tracked within limits and without collision, relocations found.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from pivotgait.exceptions import InfeasibleError, SceneError
from pivotgait.frozen import Array
from pivotgait.gaits.steps import Step
from pivotgait.kinematics import Hold
from pivotgait.models import AdditionPhase, HandleContact, LiftPhase, RelocationPhase, Robot, Scene
from pivotgait.phases.grasp import Setting
from pivotgait.phases.relocation import relocation_phase
from pivotgait.phases.tracking import JointMotion, track, with_torques
from pivotgait.planning.collision import CollisionWorld
from pivotgait.planning.key_posture import KeyPose
from pivotgait.planning.posture_search import PostureOptions, Postures, PostureSearch, SearchRecord
from pivotgait.planning.problem import RelocationOptions, RelocationProblem
from pivotgait.planning.relocation import plan_relocation
from pivotgait.planning.tool_path import PivotingTool
from pivotgait.plans import Phase, RobotMotion


@dataclass(frozen=True)
class HandOptions:
    """How the hand's motion is planned.

    Attributes:
        postures: of the search for postures.
        relocation: of the searches for paths; the scene gives their sampling time.
    """

    postures: PostureOptions = field(default_factory=PostureOptions)
    relocation: RelocationOptions = field(default_factory=RelocationOptions)


@dataclass(frozen=True, eq=False)
class HandGait:
    """A gait with its hand.

    Attributes:
        phases: with robot motion, in order.
        plan_time_s: time spent on each phase's hand, without the search for postures.
        postures: that the gait goes through.
        search_time_s: time spent on postures and on candidates that failed.
        record: of the search.
    """

    phases: tuple[Phase, ...]
    plan_time_s: tuple[float, ...]
    postures: Postures
    search_time_s: float
    record: SearchRecord


class HandPlanner:
    """Plans the arm-hand through the steps of a gait.

    Args:
        setting: scene with a robot.
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
        self.keys, self._spans = _key_poses(setting, self._steps)
        self._left = dict(_contacts_left(scene, self._steps))

    def plan(self) -> HandGait:
        """Carry the gait out from the first posture from which it can be.

        Raises:
            InfeasibleError: naming what bound most often.
        """
        began = perf_counter()
        search = PostureSearch(self._robot, self.world, self.keys, self._rng, self.options.postures)
        for postures in search.candidates():
            carried = self._carry_out(postures)
            if isinstance(carried, str):
                search.record.failures[carried] += 1
                continue
            phases, times = carried
            spent = perf_counter() - began - sum(times)
            return HandGait(tuple(phases), tuple(times), postures, spent, search.record)
        raise search.record.infeasible("the hand's gait")

    def _carry_out(self, postures: Postures) -> tuple[list[Phase], list[float]] | str:
        """The phases with robot motion, or the reason why a phase cannot be done."""
        phases, times = [], []
        # Relocations last: they take longest and are rarely what fails.
        order = sorted(range(len(self._steps)), key=lambda k: self._steps[k].phase is None)
        done: dict[int, Phase] = {}
        spent: dict[int, float] = {}
        for k in order:
            began, step = perf_counter(), self._steps[k]
            through = postures.q[slice(*self._spans[k])]
            try:
                phase = (
                    self._relocate(step, through, postures)
                    if step.phase is None
                    else self._track(step, step.phase, through, postures)
                )
            except InfeasibleError as error:
                return f"{step.name}: {error.what}"
            done[k], spent[k] = phase, perf_counter() - began
        phases = [done[k] for k in range(len(self._steps))]
        times = [spent[k] for k in range(len(self._steps))]
        return phases, times

    def _track(self, step: Step, phase: Phase, through: Array, postures: Postures) -> Phase:
        touching = {**step.before.fingers, **step.after.fingers}
        holds = _holds(postures, touching.values())
        motion = track(self._robot, holds, phase.time, phase.tool, through)
        self._check(motion, phase, frozenset(touching))
        return replace(phase, robot=self._with_torques(motion, phase))

    def _relocate(self, step: Step, through: Array, postures: Postures) -> Phase:
        scene, config, grasp = self._setting.scene, step.config, step.before
        assert isinstance(config, RelocationPhase)
        goal = scene.contacts[config.contact]
        left = self._left.get(step.name)
        rotation = grasp.rotation.as_matrix()
        problem = RelocationProblem(
            robot=self._robot,
            world=self.world,
            holds=tuple(_holds(postures, grasp.fingers.values())),
            finger=goal.finger,
            start=through[0],
            goal=through[-1],
            tool=PivotingTool.resting(rotation, scene.centre_of_mass(grasp.rotation)),
            start_normal=None if left is None else left.normal,
            goal_normal=goal.normal,
            options=replace(self.options.relocation, sample_s=config.sample_s),
        )
        result = plan_relocation(problem, self._rng)
        if result.trajectory is None:
            raise InfeasibleError(result.failure)
        path = result.trajectory
        phase = relocation_phase(self._setting, grasp, goal.finger, path.time, name=step.name)
        motion = self._with_torques(JointMotion(path.q, path.v, path.a), phase)
        record = {
            "solver": "RRT",
            "iterations": result.iterations,
            "nodes": sum(result.nodes),
            "length_found_m": result.length_found,
            "length_m": result.length,
        }
        return replace(phase, robot=motion, record=record)

    def _check(self, motion: JointMotion, phase: Phase, touching: frozenset[str]) -> None:
        """Limits, speeds and clearance at every sample.

        Raises:
            InfeasibleError: naming what is broken.
        """
        robot = self._robot
        if not robot.within_limits(motion.q):
            beyond = np.maximum(robot.lower - motion.q, motion.q - robot.upper).max(axis=0)
            worst = int(np.argmax(beyond))
            name = robot.joint_names[worst] if beyond[worst] > 0.0 else "a coupling"
            raise InfeasibleError(f"leaves the limit of {name}")
        share = np.abs(motion.v) / robot.velocity_max
        if share.max(initial=0.0) > 1.0:
            worst = int(np.argmax(share.max(axis=0)))
            raise InfeasibleError(f"is too fast for {robot.joint_names[worst]}")
        world, turn = self.world.holding(touching), phase.tool.rotation.as_matrix()
        moves = np.any(motion.q[1:] != motion.q[0])
        for k in range(len(motion.q) if moves else 1):
            if not world.free(motion.q[k], turn[k], phase.tool.position[k]):
                pair = world.clearance(motion.q[k], turn[k], phase.tool.position[k])[1]
                raise InfeasibleError(f"collision of {pair[0]} and {pair[1]}")

    def _with_torques(self, motion: JointMotion, phase: Phase) -> RobotMotion:
        """With joint torques.

        Raises:
            InfeasibleError: naming the joint whose torque limit is exceeded.
        """
        robot = self._robot
        full = with_torques(robot, motion, phase.contacts, phase.tool)
        share = np.abs(full.tau) / robot.effort_max
        if share.max() > 1.0:
            worst = int(np.argmax(share.max(axis=0)))
            raise InfeasibleError(f"exceeds the torque of {robot.joint_names[worst]}")
        return full


def _holds(postures: Postures, contacts: Iterable[HandleContact]) -> list[Hold]:
    return [postures.holds[contact.finger, contact.name] for contact in contacts]


def _key_poses(
    setting: Setting, steps: Sequence[Step]
) -> tuple[tuple[KeyPose, ...], tuple[tuple[int, int], ...]]:
    """The moments at which postures are sought, and for each step the range of those it spans."""
    keys: list[KeyPose] = []
    spans: list[tuple[int, int]] = []
    scene = setting.scene
    for step in steps:
        first, config = max(len(keys) - 1, 0), step.config
        if isinstance(config, RelocationPhase):
            goal = scene.contacts[config.contact]
            rotation = step.before.rotation
            place = scene.centre_of_mass(rotation)
            fingers = {**step.before.fingers, goal.finger: goal}
            keys.append(KeyPose(f"end of {step.name}", rotation.as_matrix(), place, fingers))
        elif isinstance(config, AdditionPhase):
            finger = scene.contacts[config.contact].finger
            if keys[-1].contacts.get(finger) != scene.contacts[config.contact]:
                raise SceneError(
                    f"nothing brings finger {finger!r} to {config.contact!r}",
                    where=step.name,
                    mend="put a relocation before the addition",
                )
            first = len(keys) - 1
        else:
            keys += _moving_keys(step)
        spans.append((first, len(keys)))
    return tuple(keys), tuple(spans)


def _moving_keys(step: Step) -> list[KeyPose]:
    """Middle and end of a phase in which the tool moves; its start too, if it is the first."""
    phase = step.phase
    assert phase is not None
    last = len(phase.time) - 1
    moments = [(last // 2, "middle"), (last, "end")]
    if isinstance(step.config, LiftPhase):
        moments.insert(0, (0, "start"))
    turn = phase.tool.rotation.as_matrix()
    return [
        KeyPose(f"{word} of {step.name}", turn[k], phase.tool.position[k], step.before.fingers)
        for k, word in moments
    ]


def _contacts_left(scene: Scene, steps: Sequence[Step]) -> Iterator[tuple[str, HandleContact]]:
    """Name of each relocation whose finger still is at a contact -> that contact."""
    at: dict[str, HandleContact] = {}
    for step in steps:
        at.update(step.before.fingers)
        if isinstance(step.config, RelocationPhase):
            goal = scene.contacts[step.config.contact]
            if goal.finger in at:
                yield step.name, at[goal.finger]
            at[goal.finger] = goal
