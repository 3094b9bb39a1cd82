"""The moments of a move at which the hand must have a posture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from scipy.spatial.transform import Rotation, Slerp

from pivotgait.gait_search.states import GraspState, Move
from pivotgait.gait_search.timing import STAND_OFF_M
from pivotgait.models import Scene
from pivotgait.planning.key_posture import KeyPose


def keys_of_move(scene: Scene, before: GraspState, move: Move) -> Iterator[KeyPose]:
    """Moments that a move adds to those before: what a gait's plan asks postures for, too."""
    after = move.after
    if move.kind == "transfer":
        yield _stood_off(scene, before)
        return
    if move.kind == "addition":
        yield _key(scene, f"end of {move.name}", after.rotation, after)
        return
    touching = after if move.kind == "lift" else before
    way = Slerp([0.0, 1.0], Rotation.concatenate((before.rotation, after.rotation)))
    for share in (0.0, 0.5, 1.0)[0 if move.kind == "lift" else 1 :]:
        yield _key(scene, f"{move.name} at {share:g}", way(share), touching)


def keys_to_come(scene: Scene, rest: Sequence[Move]) -> Iterator[KeyPose]:
    """The grasps that fingers are added to, up to the goal."""
    for move in rest:
        if move.kind == "addition":
            yield _key(scene, f"end of {move.name}", move.after.rotation, move.after)


def _stood_off(scene: Scene, state: GraspState) -> KeyPose:
    """Fingers that do not carry the tool are out of its way; then all move as one body."""
    key = _key(scene, "before the transfer", state.rotation, state)
    left = {finger: each.contact.standing_off(STAND_OFF_M) for finger, each in state.left.items()}
    return replace(key, contacts={**key.contacts, **left})


def _key(scene: Scene, name: str, rotation: Rotation, state: GraspState) -> KeyPose:
    contacts = {finger: each.contact for finger, each in state.held.items()}
    return KeyPose(name, rotation.as_matrix(), scene.centre_of_mass(rotation), contacts)
