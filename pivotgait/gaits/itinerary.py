"""The moments of a gait at which the hand's posture is sought, and the samples they stand for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pivotgait.exceptions import SceneError
from pivotgait.frozen import Array
from pivotgait.gaits.steps import Step
from pivotgait.models import (
    AdditionPhase,
    HandleContact,
    LiftPhase,
    RelocationPhase,
    RemovalPhase,
    Robot,
    Scene,
    TransferPhase,
)
from pivotgait.planning.key_posture import KeyPose
from pivotgait.plans import Phase


@dataclass(frozen=True)
class Stop:
    """A sample of a phase at a key pose.

    Attributes:
        sample: of the phase; for a relocation 0 is its start and 1 its end.
        key: place among the key poses.
    """

    sample: int
    key: int


@dataclass(frozen=True, eq=False)
class Itinerary:
    """Key poses in the order of time and the stops of each step.

    Attributes:
        keys: of the whole gait.
        stops: of each step, in order; one for a step in which the hand rests.
    """

    keys: tuple[KeyPose, ...]
    stops: tuple[tuple[Stop, ...], ...]

    @classmethod
    def of(cls, scene: Scene, steps: Sequence[Step]) -> Itinerary:
        """Start, middle and end of each phase in which the tool moves; ends of relocations.

        Steps that do not begin with a lift start from the grasp before them, at rest.

        Raises:
            SceneError: for an addition to which no relocation brings the finger.
        """
        keys = [] if isinstance(steps[0].config, LiftPhase) else [_at_rest(scene, steps[0])]
        stops: list[tuple[Stop, ...]] = []
        for step in steps:
            config, here = step.config, Stop(0, len(keys) - 1)
            if isinstance(config, RelocationPhase):
                keys.append(_after_relocation(scene, step, relocation_goal(scene, config)))
                stops.append((here, Stop(1, here.key + 1)))
            elif isinstance(config, AdditionPhase):
                _check_arrived(keys[-1], scene.contacts[config.contact], step.name)
                stops.append((here,))
            elif isinstance(config, TransferPhase):
                stops.append((here,))  # hand and tool move as one body, from where they are
            else:
                last = _last(step)
                samples = [last // 2, last]
                if isinstance(config, LiftPhase):
                    keys.append(key_at(step, 0))
                    here = Stop(0, len(keys) - 1)
                keys += [key_at(step, sample) for sample in samples]
                stops.append((here, Stop(samples[0], here.key + 1), Stop(last, here.key + 2)))
        return cls(tuple(keys), tuple(stops))

    def with_stop(self, steps: Sequence[Step], place: int, sample: int) -> tuple[Itinerary, int]:
        """One more stop within a step; also the place of its key pose.

        Args:
            steps: of the gait.
            place: of the step.
            sample: of the step's phase, not a stop yet.
        """
        later = next(stop for stop in self.stops[place] if stop.sample > sample)
        new = later.key
        keys = (*self.keys[:new], key_at(steps[place], sample), *self.keys[new:])
        stops = [
            tuple(replace(stop, key=stop.key + (stop.key >= new)) for stop in each)
            for each in self.stops
        ]
        stops[place] = tuple(sorted((*stops[place], Stop(sample, new)), key=lambda s: s.sample))
        return Itinerary(keys, tuple(stops)), new

    def postures_in(self, phases: Sequence[Phase]) -> Array:
        """(K, nv) where the hand of a plan with the same phases is at the key poses."""
        found: dict[int, Array] = {}
        for phase, stops in zip(phases, self.stops, strict=True):
            assert phase.robot is not None
            for stop in stops:
                last = phase.kind == "relocation" and stop.sample == 1
                found[stop.key] = phase.robot.q[-1 if last else stop.sample]
        return np.array([found[k] for k in range(len(self.keys))])

    def postures_suggested(self, steps: Sequence[Step], robot: Robot) -> Array | None:
        """(K, nv) where the scene says that the hand may be; None unless all phases say so."""
        found: dict[int, Array] = {}
        for step, stops in zip(steps, self.stops, strict=True):
            if len(stops) == 1:
                continue
            config = step.config
            assert isinstance(config, LiftPhase | RemovalPhase | RelocationPhase)
            if isinstance(config, LiftPhase):
                found[stops[0].key] = robot.posture(config.posture_before or config.posture)
            if not config.posture or stops[0].key not in found:
                return None
            begin, end = found[stops[0].key], robot.posture(config.posture)
            for place, stop in enumerate(stops[1:], start=1):
                found[stop.key] = begin + place / (len(stops) - 1) * (end - begin)
        return np.array([found[k] for k in range(len(self.keys))])

    def renewed(self, steps: Sequence[Step]) -> Itinerary:
        """The same stops on the steps as they are now."""
        keys = list(self.keys)
        for step, stops in zip(steps, self.stops, strict=True):
            if step.phase is None or len(stops) == 1:
                continue
            for stop in stops if isinstance(step.config, LiftPhase) else stops[1:]:
                keys[stop.key] = key_at(step, stop.sample)
        for step, stops in zip(steps, self.stops, strict=True):
            if step.phase is None:
                turn = step.before.rotation.as_matrix()
                position = keys[stops[0].key].position
                keys[stops[1].key] = replace(keys[stops[1].key], rotation=turn, position=position)
        return Itinerary(tuple(keys), self.stops)


def key_at(step: Step, sample: int) -> KeyPose:
    """The tool and its contacts at a sample of a step in which it moves."""
    phase = step.phase
    assert phase is not None
    turn, time = phase.tool.rotation[sample].as_matrix(), phase.time[sample]
    name = f"{step.name} at {time:.2f} s"
    return KeyPose(name, turn, phase.tool.position[sample], step.before.fingers)


def contacts_left(scene: Scene, steps: Sequence[Step]) -> Iterator[tuple[str, HandleContact]]:
    """Name of each relocation whose finger still is at a contact -> that contact."""
    at: dict[str, HandleContact] = {}
    for step in steps:
        at.update(step.before.fingers)
        if isinstance(step.config, RelocationPhase):
            goal = scene.contacts[step.config.contact]
            if goal.finger in at:
                yield step.name, at.pop(goal.finger)
            if step.config.standoff_m == 0.0:
                at[goal.finger] = goal


def relocation_goal(scene: Scene, config: RelocationPhase) -> HandleContact:
    """Where a relocation brings its finger: the contact itself, or a place before it."""
    contact = scene.contacts[config.contact]
    return contact.standing_off(config.standoff_m) if config.standoff_m > 0.0 else contact


def _at_rest(scene: Scene, step: Step) -> KeyPose:
    rotation = step.before.rotation
    place = scene.centre_of_mass(rotation)
    return KeyPose(f"before {step.name}", rotation.as_matrix(), place, step.before.fingers)


def _last(step: Step) -> int:
    assert step.phase is not None
    return len(step.phase.time) - 1


def _after_relocation(scene: Scene, step: Step, goal: HandleContact) -> KeyPose:
    rotation = step.before.rotation
    fingers = {**step.before.fingers, goal.finger: goal}
    place = scene.centre_of_mass(rotation)
    return KeyPose(f"end of {step.name}", rotation.as_matrix(), place, fingers)


def _check_arrived(key: KeyPose, contact: HandleContact, where: str) -> None:
    if key.contacts.get(contact.finger) is not contact:
        raise SceneError(
            f"nothing brings finger {contact.finger!r} to {contact.name!r}",
            where=where,
            mend="put a relocation before the addition",
        )
